"""What SC-experiments discover that their alternatives do not, from the same starts (paper, section
IV-A, "Alternatives are not adapted").

Experiments of a cluttered scene share objects and layouts, so the scene is the unit of intervals
and tests.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import table
from ..columns import COMPARISON, KIND
from .mask_summary import RESAMPLES

COMPARISONS = ("sc-experiment", "first-last", "return")
KINDS = ("random", "left-right")
DISCOVERED = 0.5
"""Intersection over union of both masks together from which an object counts as discovered.
Chosen: the usual threshold in object detection."""


def summarize_comparisons(alternatives: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Rows of mask_discoveries, one per comparison, for one kind of sequence.

    Parameters
    ----------
    alternatives : DataFrame
        The rows of mask_alternatives of that kind.
    rng : numpy.random.Generator
    """
    from ....statistics.aggregates import percentile_interval
    from ....statistics.clusters import (
        cluster_means,
        paired_cluster_difference,
        resample_clusters,
    )
    from ....statistics.paired import mcnemar

    tables = {
        name: rows.set_index("experiment").sort_index()
        for name, rows in alternatives.groupby("comparison")
    }
    discovered = {name: is_discovery(table) for name, table in tables.items()}
    different = {
        name: (table["outcome_predicted"] == "different").to_numpy()
        for name, table in tables.items()
    }
    reference = COMPARISONS[0]
    touched = tables[reference]["touched_first"].to_numpy()
    untouched = ~tables[reference]["touched"].to_numpy()
    scene = tables[reference]["household"]
    clusters, counts = resample_clusters(scene, RESAMPLES, rng)

    def rate(values: np.ndarray) -> tuple[float, float, float]:
        """Mean of `values` (n,), ignoring NaN, with its interval: bootstrap over scenes."""
        if not np.isfinite(values).any():
            return np.nan, np.nan, np.nan
        with np.errstate(invalid="ignore", divide="ignore"):
            means = cluster_means(values, clusters, counts)
        return float(np.nanmean(values)), *percentile_interval(means[np.isfinite(means)], 0.95)

    rows = []
    for comparison in COMPARISONS:
        predicted = tables[comparison]["outcome_predicted"]
        truth = tables[comparison]["outcome_true"]
        discovery_rate, low, high = rate(100.0 * discovered[comparison])
        tpr = rate(np.where(touched, different[comparison], np.nan))
        fpr = rate(np.where(untouched, different[comparison], np.nan))
        _, difference, *_, p = paired_cluster_difference(
            100.0 * discovered[comparison] - 100.0 * discovered[reference], scene
        )
        tpr_difference, tpr_p = np.nan, np.nan
        if touched.any():
            _, tpr_difference, *_, tpr_p = paired_cluster_difference(
                (different[comparison] - 1.0 * different[reference])[touched], scene[touched]
            )
        rows.append(
            dict(
                comparison=comparison,
                n=len(truth),
                n_moved=int((truth == "moved").sum()),
                discovered=int(discovered[comparison].sum()),
                discovery_rate=discovery_rate,
                ci_low=low,
                ci_high=high,
                false_alarms=int(((predicted == "moved") & (truth != "moved")).sum()),
                difference=difference,
                p=p,
                p_experiments=mcnemar(discovered[comparison], discovered[reference]).p,
                n_touched=int(touched.sum()),
                **dict(zip(("tpr", "tpr_low", "tpr_high"), tpr, strict=True)),
                tpr_difference=tpr_difference,
                tpr_p=tpr_p,
                n_untouched=int(untouched.sum()),
                **dict(zip(("fpr", "fpr_low", "fpr_high"), fpr, strict=True)),
            )
        )
    return pd.DataFrame(rows)


def is_discovery(rows: pd.DataFrame) -> np.ndarray:
    """Experiments in which a moved object is found, and where: bool (n,)."""
    return (
        (rows["outcome_predicted"] == "moved")
        & (rows["outcome_true"] == "moved")
        & (rows["overlap"] >= DISCOVERED)
    ).to_numpy()


def _nullable(name: str, description: str) -> Column:
    return Column(name, FLOAT, "1", description, nullable=True)


@table(
    title="Discoveries of SC-experiments and their alternatives",
    columns=(
        KIND,
        COMPARISON,
        Column("n", INT, "1", "experiments, all from the same starts"),
        Column("n_moved", INT, "1", "in which a visible object moved and the view is the same"),
        Column(
            "discovered", INT, "1",
            "in which that is predicted, and where: intersection over union of at least one half",
        ),
        Column("discovery_rate", FLOAT, "1", "discoveries per hundred experiments"),
        *INTERVAL,
        Column("false_alarms", INT, "1", "predicted as moved, but the outcome is another"),
        Column(
            "difference", FLOAT, "1", "discoveries per hundred less those of SC-experiments",
            nullable=True,
        ),
        Column("p", FLOAT, "1", "paired t-test of that difference, over cluttered scenes"),
        Column(
            "p_experiments", FLOAT, "1", "exact McNemar test of it, as if experiments were independent"
        ),
        Column("n_touched", INT, "1", "experiments whose first order touched an immovable object"),
        _nullable("tpr", "true positive rate: the fraction of them predicted as different"),
        _nullable("tpr_low", "lower end of its 95 % interval"),
        _nullable("tpr_high", "upper end"),
        _nullable("tpr_difference", "tpr less that of SC-experiments"),
        _nullable("tpr_p", "paired t-test of that difference, over cluttered scenes"),
        Column("n_untouched", INT, "1", "experiments that touched nothing immovable in any order"),
        _nullable("fpr", "false positive rate: the fraction of them predicted as different"),
        _nullable("fpr_low", "lower end of its 95 % interval"),
        _nullable("fpr_high", "upper end"),
    ),
    inputs=["mask_alternatives"],
)  # fmt: skip
def mask_discoveries(alternatives: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Each kind of sequence by itself."""
    tables = []
    for kind in KINDS:
        rows = alternatives[alternatives["kind"] == kind]
        if len(rows):
            rng = generator(config.seed, "masks", "discoveries", kind)
            tables.append(summarize_comparisons(rows, rng).assign(kind=kind))
    return pd.concat(tables, ignore_index=True)
