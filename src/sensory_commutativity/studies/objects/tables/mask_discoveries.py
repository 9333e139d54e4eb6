"""What SC-experiments discover that their alternatives do not, from the same starts (paper, section
IV-A, "Alternatives are not adapted").

Experiments of a cluttered scene share objects and layouts, so the scene is the unit of intervals
and tests.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import table
from ..columns import COMPARISON, COMPARISONS, KIND
from .mask_summary import RESAMPLES

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
    from ....statistics.clusters import resample_clusters

    tables = {
        name: rows.set_index("experiment").sort_index()
        for name, rows in alternatives.groupby("comparison")
    }
    reference = tables[COMPARISONS[0]]
    resamples = resample_clusters(reference["household"], RESAMPLES, rng)
    return pd.DataFrame(
        [
            dict(comparison=name, **_compare(tables[name], reference, resamples))
            for name in COMPARISONS
        ]
    )


def _compare(
    table: pd.DataFrame, reference: pd.DataFrame, resamples: tuple[Any, Any]
) -> dict[str, float]:
    """One comparison against the SC-experiments `reference`, from the same starts.

    `resamples` are the clusters and counts of :func:`.statistics.clusters.resample_clusters`.
    """
    from ....statistics.clusters import paired_cluster_difference
    from ....statistics.paired import mcnemar

    scene = reference["household"]
    touched, untouched = reference["touched_first"].to_numpy(), ~reference["touched"].to_numpy()
    discovered, discovered_reference = is_discovery(table), is_discovery(reference)
    different, different_reference = (
        (rows["outcome_predicted"] == "different").to_numpy() for rows in (table, reference)
    )
    rate, low, high = _rate(100.0 * discovered, resamples)
    tpr = _rate(np.where(touched, different, np.nan), resamples)
    fpr = _rate(np.where(untouched, different, np.nan), resamples)
    _, difference, *_, p = paired_cluster_difference(
        100.0 * discovered - 100.0 * discovered_reference, scene
    )
    tpr_difference, tpr_p = np.nan, np.nan
    if touched.any():
        _, tpr_difference, *_, tpr_p = paired_cluster_difference(
            (different - 1.0 * different_reference)[touched], scene[touched]
        )
    truth = table["outcome_true"]
    return dict(
        n=len(table),
        n_moved=int((truth == "moved").sum()),
        discovered=int(discovered.sum()),
        discovery_rate=rate,
        ci_low=low,
        ci_high=high,
        false_alarms=int(((table["outcome_predicted"] == "moved") & (truth != "moved")).sum()),
        difference=difference,
        p=p,
        p_experiments=mcnemar(discovered, discovered_reference).p,
        n_touched=int(touched.sum()),
        **dict(zip(("tpr", "tpr_low", "tpr_high"), tpr, strict=True)),
        tpr_difference=tpr_difference,
        tpr_p=tpr_p,
        n_untouched=int(untouched.sum()),
        **dict(zip(("fpr", "fpr_low", "fpr_high"), fpr, strict=True)),
    )


def _rate(values: np.ndarray, resamples: tuple[Any, Any]) -> tuple[float, float, float]:
    """Mean of `values` (n,), ignoring NaN, with its interval: bootstrap over scenes."""
    from ....statistics.aggregates import percentile_interval
    from ....statistics.clusters import cluster_means

    if not np.isfinite(values).any():
        return np.nan, np.nan, np.nan
    with np.errstate(invalid="ignore", divide="ignore"):
        means = cluster_means(values, *resamples)
    return float(np.nanmean(values)), *percentile_interval(means[np.isfinite(means)], 0.95)


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
        Column(
            "discovery_rate", FLOAT, "1", "discoveries per hundred experiments", low=0, high=100
        ),
        *INTERVAL,
        Column("false_alarms", INT, "1", "predicted as moved, but the outcome is another"),
        Column(
            "difference", FLOAT, "1", "discoveries per hundred less those of SC-experiments",
            nullable=True,
        ),
        Column(
            "p", FLOAT, "1", "paired t-test of that difference, over cluttered scenes",
            low=0, high=1,
        ),
        Column(
            "p_experiments", FLOAT, "1",
            "exact McNemar test of it, as if experiments were independent", low=0, high=1,
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
