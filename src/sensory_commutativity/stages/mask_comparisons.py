"""RAFT against the others, on the same tuples: exact McNemar tests of the outcomes, paired t-tests of the overlaps, Holm-corrected."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from ..config import Config
from ..statistics.paired import holm, mcnemar, paired_difference_interval
from ..tables import read_table, write_table
from .apartment_hierarchy import paired_means
from .mask_summary import ious

BETTER = "raft"
"""The model that the paper found better (section IV-A)."""


def compared(scores: pd.DataFrame) -> pd.DataFrame:
    """All comparisons of BETTER with another model on a test set; `scores` is a mask_scores table."""
    rows = []
    for test_set, found in scores.groupby("test_set", sort=False):
        tables = {model: rows_of.set_index("experiment").sort_index() for model, rows_of in found.groupby("model", sort=False)}
        ours = tables.pop(BETTER)
        for other, theirs in tables.items():
            if not ours.index.equals(theirs.index):
                raise ValueError(f"{test_set}: {BETTER} and {other} were not scored on the same tuples")
            right = [(table["outcome_true"] == table["outcome_predicted"]).to_numpy() for table in (ours, theirs)]
            test = mcnemar(*right)
            interval = paired_difference_interval(test.only_a, test.only_b, len(ours))
            rows.append((BETTER, other, test_set, "accuracy", len(ours), test.difference, *interval, test.p, np.nan))
            moved = (ours["outcome_true"] == "moved").to_numpy()
            difference = np.nan_to_num(ious(ours[moved])) - np.nan_to_num(ious(theirs[moved]))
            if len(difference) > 1:
                low, high, p = paired_means(difference)
                wilcoxon = float(stats.wilcoxon(difference).pvalue) if difference.any() else 1.0
                rows.append((BETTER, other, test_set, "iou", len(difference), float(difference.mean()), low, high, p, wilcoxon))
    columns = ["a", "b", "test_set", "measure", "n", "difference", "ci_low", "ci_high", "p", "p_wilcoxon"]
    table = pd.DataFrame(rows, columns=columns)
    return table.assign(p_adjusted=holm(table["p"].to_numpy()))


def write_comparisons(mask_scores: Path, out: Path, config: Config) -> None:
    """A row per other model, test set and measure."""
    write_table("mask_comparisons", compared(read_table("mask_scores", mask_scores)), out, config)
