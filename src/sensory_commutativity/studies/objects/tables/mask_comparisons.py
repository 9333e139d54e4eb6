"""RAFT against the other models on the same tuples: paired t-tests over cluttered scenes,
Holm-corrected, beside tests that take tuples as independent.

The comparisons are about these trained models: one training of each says nothing about how much
another training would differ.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....storage.columns import FLOAT, INT, INTERVAL, P_VALUES, TEXT, Column
from ...config import Config
from ...declarations import table
from ..columns import TEST_SET
from .mask_summary import mean_iou_per_tuple

REFERENCE_MODEL = "raft"
"""The model that the paper found better (section IV-A)."""


def compare_models(scores: pd.DataFrame) -> pd.DataFrame:
    """Compare REFERENCE_MODEL with every other model on every test set, from mask_scores."""
    from scipy import stats

    from ....statistics.clusters import paired_cluster_difference
    from ....statistics.paired import holm, mcnemar

    rows = []
    for test_set, group in scores.groupby("test_set", sort=False):
        tables = {
            model: table.set_index("experiment").sort_index()
            for model, table in group.groupby("model", sort=False)
        }
        reference = tables.pop(REFERENCE_MODEL)
        truth = reference["outcome_true"]
        moved = (truth == "moved").to_numpy()
        # Each outcome has the same weight, as in mask_summary.
        weight = len(truth) / truth.nunique() / truth.map(truth.value_counts())
        for other, table_of_other in tables.items():
            if not reference.index.equals(table_of_other.index):
                raise ValueError(
                    f"{test_set}: {REFERENCE_MODEL} and {other} were not scored on the same tuples"
                )
            correct = [
                (table["outcome_true"] == table["outcome_predicted"]).to_numpy()
                for table in (reference, table_of_other)
            ]
            difference = (correct[0].astype(float) - correct[1]) * weight.to_numpy()
            clustered = paired_cluster_difference(difference, reference["household"])
            rows.append(
                (REFERENCE_MODEL, other, test_set, "accuracy", *clustered, mcnemar(*correct).p)
            )
            difference = np.nan_to_num(mean_iou_per_tuple(reference[moved])) - np.nan_to_num(
                mean_iou_per_tuple(table_of_other[moved])
            )
            if len(difference):
                wilcoxon = float(stats.wilcoxon(difference).pvalue) if difference.any() else 1.0
                clustered = paired_cluster_difference(difference, reference["household"][moved])
                rows.append((REFERENCE_MODEL, other, test_set, "iou", *clustered, wilcoxon))
    columns = ["a", "b", "test_set", "measure", "n", "difference", "ci_low", "ci_high",
               "households", "p", "p_tuples"]  # fmt: skip
    comparisons = pd.DataFrame(rows, columns=columns)
    return comparisons.assign(p_adjusted=holm(comparisons["p"].to_numpy()))


@table(
    title="RAFT against the other models",
    columns=(
        Column("a", TEXT, "", "one model", key=True),
        Column("b", TEXT, "", "another, on the same tuples", key=True),
        TEST_SET,
        Column("measure", TEXT, "", "accuracy or iou", key=True),
        Column("n", INT, "1", "tuples"),
        Column("difference", FLOAT, "1", "a minus b", nullable=True),
        *INTERVAL,
        Column("households", INT, "1", "cluttered scenes, which are independent"),
        *P_VALUES,
        Column(
            "p_tuples", FLOAT, "1",
            "p-value as if tuples were independent: exact McNemar test of the outcomes, Wilcoxon "
            "test of the overlaps", nullable=True, low=0, high=1,
        ),
    ),
    inputs=["mask_scores"],
)  # fmt: skip
def mask_comparisons(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per other model, test set and measure."""
    return compare_models(scores)
