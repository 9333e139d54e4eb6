"""The output tables: their columns, types and units, and how they are written and read.

A table is tidy: one row per thing counted. Units and provenance stand in the Parquet file's own metadata. A file is written under a temporary name
and renamed, so that whatever has its final name is complete.
"""

from __future__ import annotations

import glob
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from .config import Config
from .errors import TableError
from .provenance import provenance

NULLABLE = (
    "ci_low", "ci_high", "excess_error", "spearman", "kendall", "statistic", "df", "difference", "effect_size",
    "median", "median_low", "median_high", "iqm", "iqm_low", "iqm_high",
)  # fmt: skip
"""Columns that may be empty: where there is no single number, or it is not defined."""


class Column(NamedTuple):
    name: str
    type: pa.DataType
    unit: str
    description: str


_TEXT, _INT, _FLOAT, _BOOL = pa.string(), pa.int64(), pa.float64(), pa.bool_()
_WHERE = (
    Column("world", _TEXT, "", "kind of room, a key of flatland.worlds"),
    Column("agent", _TEXT, "", "a key of flatland.agents"),
)
_INTERVAL = (
    Column("ci_low", _FLOAT, "1", "lower end of the 95 % interval"),
    Column("ci_high", _FLOAT, "1", "upper end of the 95 % interval"),
)
_SCP = (
    *_WHERE,
    Column("length", _INT, "actions", "length of the sequences"),
    Column("dof", _TEXT, "", "degree of freedom"),
    Column("threshold", _FLOAT, "squared 8-bit colour", "largest distance that counts as equal"),
    Column("n", _INT, "1", "SC-experiments"),
    Column("commuted", _INT, "1", "how many of them commuted"),
    Column("scp", _FLOAT, "1", "sensory commutativity probability"),
    *_INTERVAL,
)
_TEST = (
    Column("p", _FLOAT, "1", "two-sided p-value"),
    Column("p_adjusted", _FLOAT, "1", "p-value after Holm's correction"),
)
_RUN = (
    Column("action_space", _TEXT, "", "full, truncated, adapted, random-half or inverse"),
    Column("seed", _INT, "1", "which training run"),
)
_PAIR = (
    Column("family", _TEXT, "", "paper: the three action spaces that the paper compares; controls: the other pairs"),
    Column("a", _TEXT, "", "action space"),
    Column("b", _TEXT, "", "action space"),
)

TABLES: dict[str, tuple[Column, ...]] = {
    "flatland_experiments": (
        *_WHERE,
        Column("length", _INT, "actions", "length of the sequences"),
        Column("dof", _TEXT, "", "degree of freedom"),
        Column("experiment", _INT, "1", "number of the experiment; all degrees of freedom share its start situation"),
        Column("seed", _INT, "1", "seed of the experiment"),
        Column("distance", _FLOAT, "squared 8-bit colour", "mean squared error of the two final observations"),
    ),
    "flatland_scp": _SCP,
    "flatland_sensitivity": _SCP,
    "flatland_comparisons": (
        *_WHERE,
        Column("dof_a", _TEXT, "", "degree of freedom"),
        Column("dof_b", _TEXT, "", "degree of freedom"),
        Column("test", _TEXT, "", "name of the test"),
        Column("n", _INT, "1", "start situations that both were tried in"),
        Column("only_a", _INT, "1", "situations in which only a commuted"),
        Column("only_b", _INT, "1", "situations in which only b commuted"),
        Column("difference", _FLOAT, "1", "SCP of a minus SCP of b"),
        *_INTERVAL,
        *_TEST,
    ),
    "flatland_trends": (
        Column("trend", _TEXT, "", "objects or arm length"),
        Column("stratum", _TEXT, "", "the agent, for objects; all worlds, for arm length"),
        Column("dof", _TEXT, "", "degree of freedom"),
        Column("test", _TEXT, "", "name of the test"),
        Column("statistic", _FLOAT, "1", "z of the trend, or the pooled odds ratio"),
        Column("effect", _FLOAT, "1", "change of SCP per object, or from the shorter to the longer arms"),
        *_TEST,
    ),
    "flatland_commutation_experiments": (
        _WHERE[0],
        Column("dof_a", _TEXT, "", "degree of freedom"),
        Column("dof_b", _TEXT, "", "degree of freedom"),
        Column("experiment", _INT, "1", "number of the experiment; all pairs share its start situation"),
        Column("seed", _INT, "1", "seed of the experiment"),
        Column("distance", _FLOAT, "squared 8-bit colour", "mean squared error of the two final observations"),
    ),
    "flatland_commutation": (
        _WHERE[0],
        Column("dof_a", _TEXT, "", "degree of freedom"),
        Column("dof_b", _TEXT, "", "degree of freedom"),
        Column("n", _INT, "1", "experiments"),
        Column("commuted", _INT, "1", "how many of them commuted"),
        Column("probability", _FLOAT, "1", "probability that a then b and b then a end equal"),
        *_INTERVAL,
    ),
    "flatland_baselines": (
        Column("dof", _TEXT, "", "degree of freedom"),
        Column("naive_mse", _FLOAT, "squared 8-bit colour", "mean squared change of the observation in a transition"),
        Column("naive_se", _FLOAT, "squared 8-bit colour", "standard error of naive_mse, sequences as units"),
        Column("prediction_mse", _FLOAT, "squared 8-bit colour", "mean squared error of the predicted next observation, test transitions"),
        Column("prediction_se", _FLOAT, "squared 8-bit colour", "standard error of prediction_mse, sequences as units"),
        Column("excess_error", _FLOAT, "squared 8-bit colour", "prediction_mse less the smallest of all degrees of freedom"),
        Column("n_transitions", _INT, "1", "transitions"),
        Column("n_test", _INT, "1", "transitions that tested the prediction"),
    ),
    "flatland_alternatives": (
        Column("alternative", _TEXT, "", "naive change or excess prediction error"),
        Column("n", _INT, "1", "degrees of freedom"),
        Column("spearman", _FLOAT, "1", "Spearman's rank correlation with 1 - SCP; 1 would be the same order"),
        Column("kendall", _FLOAT, "1", "Kendall's tau-b with 1 - SCP"),
        Column("p", _FLOAT, "1", "two-sided p-value of Spearman's coefficient, permutation test"),
    ),
    "navigation_scp": _SCP,
    "navigation_action_spaces": (
        *_RUN,
        Column("dof", _TEXT, "", "degree of freedom"),
        Column("scp", _FLOAT, "1", "its measured sensory commutativity probability"),
        Column("scale", _FLOAT, "1", "factor of its action interval; 0 fixes it"),
    ),
    "navigation_curves": (
        *_RUN,
        Column("step", _INT, "steps", "environment steps of training before this evaluation"),
        Column("episode_return", _FLOAT, "reward", "mean return of the evaluation's episodes"),
        Column("success_rate", _FLOAT, "1", "fraction of episodes that ended in the goal"),
        Column("dead_rate", _FLOAT, "1", "fraction of episodes that ended in a dead zone"),
        Column("episode_length", _FLOAT, "steps", "mean length of the episodes"),
        Column("episodes", _INT, "1", "episodes of the evaluation"),
    ),
    "navigation_scores": (
        *_RUN,
        Column("final_return", _FLOAT, "reward", "mean return at the last evaluation"),
        Column("auc", _FLOAT, "reward", "mean return over all evaluations: the area under the learning curve"),
        Column("success_rate", _FLOAT, "1", "fraction of episodes that ended in the goal at the last evaluation"),
        Column("steps_to_threshold", _FLOAT, "steps", "first evaluation with the threshold return; the whole run where none had it"),
        Column("reached", _BOOL, "", "whether the threshold return was reached; if not, steps_to_threshold is censored"),
        Column("solved", _BOOL, "", "whether the last evaluation has the success rate that counts as solved"),
    ),
    "navigation_summary": (
        Column("action_space", _TEXT, "", "which action space"),
        Column("measure", _TEXT, "", "a score, or the fraction of runs that reached the threshold or solved the task"),
        Column("n", _INT, "1", "runs"),
        Column("mean", _FLOAT, "of the measure", "mean"),
        Column("mean_low", _FLOAT, "of the measure", "95 % interval of the mean: Student's t; Wilson's for fractions of runs"),
        Column("mean_high", _FLOAT, "of the measure", "its upper end"),
        Column("median", _FLOAT, "of the measure", "median"),
        Column("median_low", _FLOAT, "of the measure", "95 % interval, bootstrap"),
        Column("median_high", _FLOAT, "of the measure", "its upper end"),
        Column("iqm", _FLOAT, "of the measure", "interquartile mean"),
        Column("iqm_low", _FLOAT, "of the measure", "95 % interval, bootstrap"),
        Column("iqm_high", _FLOAT, "of the measure", "its upper end"),
    ),
    "navigation_comparisons": (
        *_PAIR,
        Column("measure", _TEXT, "", "which score"),
        Column("test", _TEXT, "", "name of the test; Welch decides"),
        Column("statistic", _FLOAT, "1", "of the test"),
        Column("df", _FLOAT, "1", "degrees of freedom"),
        *_TEST,
        Column("difference", _FLOAT, "of the measure", "mean of a minus mean of b"),
        Column(
            "ci_low",
            _FLOAT,
            "of the measure",
            "lower end of the 95 % interval of the difference, or else of the effect size",
        ),
        Column("ci_high", _FLOAT, "of the measure", "its upper end"),
        Column("effect", _TEXT, "", "what effect_size is"),
        Column("effect_size", _FLOAT, "1", "Hedges' g, the probability that a run of a is better, or the ratio of the mean steps"),
        Column("agrees", _TEXT, "", "yes or no: whether the test decides as Welch's does; empty for Welch's own and for other questions"),
    ),
    "navigation_checkpoints": (
        Column("step", _INT, "steps", "environment steps of training"),
        *_PAIR,
        Column("difference", _FLOAT, "reward", "mean return of a minus that of b"),
        Column("ci_low", _FLOAT, "reward", "lower end of its 95 % interval, not corrected"),
        Column("ci_high", _FLOAT, "reward", "its upper end"),
        Column("p", _FLOAT, "1", "two-sided p-value, Welch"),
        Column("p_adjusted", _FLOAT, "1", "p-value after Holm's correction over all checkpoints and pairs of the family"),
    ),
    "navigation_survival": (
        Column("action_space", _TEXT, "", "which action space"),
        Column("step", _FLOAT, "steps", "environment steps of training"),
        Column("at_risk", _INT, "1", "runs that had not reached the threshold before"),
        Column("events", _INT, "1", "runs that reached it here"),
        Column("survival", _FLOAT, "1", "Kaplan-Meier estimate of the fraction of runs that have not reached it"),
        *_INTERVAL,
    ),
    "navigation_profiles": (
        Column("action_space", _TEXT, "", "which action space"),
        Column("threshold", _FLOAT, "reward", "final return"),
        Column("n", _INT, "1", "runs"),
        Column("above", _INT, "1", "runs with at least this final return"),
        Column("fraction", _FLOAT, "1", "their fraction"),
        *_INTERVAL,
    ),
    "navigation_calibration": (
        Column("method", _TEXT, "", "how two groups are made from one: random halves, or resampled with replacement to full size"),
        Column("action_space", _TEXT, "", "whose runs were compared; all: together, but for those whose runs are all equal"),
        Column("measure", _TEXT, "", "which score"),
        Column("splits", _INT, "1", "pairs of groups that were compared (A/A)"),
        Column("rejected", _INT, "1", "how many differed significantly"),
        Column("rate", _FLOAT, "1", "their fraction"),
        Column("alpha", _FLOAT, "1", "what it should be"),
        Column("band_low", _FLOAT, "1", "central 95 % of the rate if each comparison rejected independently with probability alpha"),
        Column("band_high", _FLOAT, "1", "its upper end"),
    ),
    "navigation_power": (
        Column("question", _TEXT, "", "what is asked"),
        Column("a", _TEXT, "", "action space, where an observed effect is meant"),
        Column("b", _TEXT, "", "the other"),
        Column("alpha", _FLOAT, "1", "significance level: family-wise, and divided by three pairs"),
        Column("n", _FLOAT, "1", "runs of each action space"),
        Column("effect_size", _FLOAT, "1", "standardised difference of means"),
        Column("power", _FLOAT, "1", "probability to find it"),
    ),
    "paper_comparison": (
        Column("claim", _TEXT, "", "what the paper says"),
        Column("section", _TEXT, "", "where"),
        Column("paper_value", _TEXT, "", "the paper's value, as far as it gives one"),
        Column("our_value", _TEXT, "", "what this run measured"),
        Column("ci_low", _FLOAT, "1", "lower end of the 95 % interval, where the value is one number"),
        Column("ci_high", _FLOAT, "1", "upper end of the 95 % interval, where the value is one number"),
        Column("holds", _BOOL, "", "whether the claim holds in this run"),
    ),
}


def schema(name: str) -> pa.Schema:
    """The Arrow schema of the table `name`, units and descriptions in each field's metadata."""
    fields = [pa.field(c.name, c.type, nullable=c.name in NULLABLE, metadata={"unit": c.unit, "description": c.description}) for c in TABLES[name]]
    return pa.schema(fields)


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path` to write to; it gets its final name only when all went well."""
    path.parent.mkdir(parents=True, exist_ok=True)
    for left in path.parent.glob(f".{glob.escape(path.name)}.*.part*"):  # by a process that was killed
        left.unlink(missing_ok=True)
    handle, temporary = tempfile.mkstemp(prefix=f".{path.name}.", suffix=f".part{path.suffix}", dir=path.parent)
    os.close(handle)
    try:
        yield Path(temporary)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    finally:
        Path(temporary).unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_table(name: str, frame: pd.DataFrame, path: str | Path, config: Config) -> None:
    """Write `frame` as the table `name`; its columns must be those of the schema."""
    table = pa.Table.from_pandas(frame[[c.name for c in TABLES[name]]], schema(name), preserve_index=False)
    table = table.replace_schema_metadata({"table": name, **provenance(config)})
    with written_whole(Path(path)) as temporary:
        pq.write_table(table, temporary, compression="zstd")


def read_table(name: str, path: str | Path) -> pd.DataFrame:
    """Read the table `name`. Raises TableError when the file is missing, damaged or another table."""
    try:
        table = pq.read_table(path)
        names = table.schema.names  # decoded only now
    except FileNotFoundError:
        raise TableError(f"{path}: there is no such table; run the workflow, or give the path of a {name} table") from None
    except (pa.ArrowException, OSError) as error:
        raise TableError(f"{path}: not a readable Parquet file ({str(error).splitlines()[0]}); delete it and run again") from None
    except UnicodeDecodeError:
        raise TableError(f"{path}: not a readable Parquet file (damaged text); delete it and run again") from None
    expected = schema(name)
    if names != expected.names or table.schema.types != expected.types:
        raise TableError(f"{path}: not a {name} table, its columns are {', '.join(names)}; delete it and run again")
    return table.to_pandas()
