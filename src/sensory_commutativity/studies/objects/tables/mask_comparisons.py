"""RAFT against the others, on the same tuples: paired t-tests over households, Holm-corrected; tests that take tuples for independent beside them.

They are about these trained models: one training of each says nothing of how much another would give.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from ....statistics.paired import holm, mcnemar
from ....storage.tables import read_table, write_table
from ...apartment.tables.apartment_hierarchy import paired_means
from ...config import Config
from .mask_summary import ious

BETTER = "raft"
"""The model that the paper found better (section IV-A)."""


def compared(scores: pd.DataFrame) -> pd.DataFrame:
    """All comparisons of BETTER with another model on a test set; `scores` is a mask_scores table."""
    rows = []
    for test_set, found in scores.groupby("test_set", sort=False):
        tables = {
            model: rows_of.set_index("experiment").sort_index()
            for model, rows_of in found.groupby("model", sort=False)
        }
        ours = tables.pop(BETTER)
        for other, theirs in tables.items():
            if not ours.index.equals(theirs.index):
                raise ValueError(
                    f"{test_set}: {BETTER} and {other} were not scored on the same tuples"
                )
            right = [
                (table["outcome_true"] == table["outcome_predicted"]).to_numpy()
                for table in (ours, theirs)
            ]
            truth = ours["outcome_true"]
            weight = (
                len(truth) / truth.nunique() / truth.map(truth.value_counts())
            )  # each outcome counts as much, as in mask_summary
            difference = (right[0].astype(float) - right[1]) * weight.to_numpy()
            rows.append(
                (
                    BETTER,
                    other,
                    test_set,
                    "accuracy",
                    *by_household(difference, ours["household"]),
                    mcnemar(*right).p,
                )
            )
            moved = (ours["outcome_true"] == "moved").to_numpy()
            difference = np.nan_to_num(ious(ours[moved])) - np.nan_to_num(ious(theirs[moved]))
            if len(difference):
                wilcoxon = float(stats.wilcoxon(difference).pvalue) if difference.any() else 1.0
                rows.append(
                    (
                        BETTER,
                        other,
                        test_set,
                        "iou",
                        *by_household(difference, ours["household"][moved]),
                        wilcoxon,
                    )
                )
    columns = [
        "a",
        "b",
        "test_set",
        "measure",
        "n",
        "difference",
        "ci_low",
        "ci_high",
        "households",
        "p",
        "p_tuples",
    ]
    table = pd.DataFrame(rows, columns=columns)
    return table.assign(p_adjusted=holm(table["p"].to_numpy()))


def by_household(
    difference: np.ndarray, household: pd.Series
) -> tuple[int, float, float, float, int, float]:
    """Number, mean and interval of paired differences (n,), number of households, and the p-value of a t-test of the households' means.

    Tuples of a household share objects and places, so the household is the unit; each counts by its number of tuples.
    """
    groups = pd.Series(difference).groupby(household.to_numpy())
    n, mean = len(difference), float(difference.mean())
    weighted = (groups.sum() * groups.ngroups / n).to_numpy()  # their mean is that of all tuples
    if groups.ngroups < 2:
        return n, mean, np.nan, np.nan, groups.ngroups, 1.0
    low, high, p = paired_means(weighted)
    return n, mean, low, high, groups.ngroups, p


def write_comparisons(mask_scores: Path, out: Path, config: Config) -> None:
    """A row per other model, test set and measure."""
    write_table("mask_comparisons", compared(read_table("mask_scores", mask_scores)), out, config)
