"""How good each model is on each test set: accuracy of the three outcomes, overlap of the masks, with intervals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ..config import Config
from ..masks.outcome import OUTCOMES
from ..seeding import generator
from ..statistics.aggregates import percentile_interval, resampling_counts
from ..tables import read_table, write_table

RESAMPLES = 9_999


def ious(scores: pd.DataFrame) -> np.ndarray:
    """Mean intersection over union of both masks of each row in which something moved; NaN of others: float64 (n,)."""
    with np.errstate(invalid="ignore"):
        return scores[["iou_1", "iou_2"]].mean(axis=1).to_numpy()


def summarised(scores: pd.DataFrame, rng: np.random.Generator) -> dict[str, float]:
    """One row of the table mask_summary, of the scores of one model on one test set.

    The interval of the accuracy is that of a bootstrap within each outcome; that of the overlap one over tuples.
    """
    right = (scores["outcome_true"] == scores["outcome_predicted"]).to_numpy(float)
    groups = {outcome: right[(scores["outcome_true"] == outcome).to_numpy()] for outcome in OUTCOMES}
    there = [found for found in groups.values() if len(found)]
    resampled = np.mean([resampling_counts(len(found), RESAMPLES, rng) @ found / len(found) for found in there], axis=0)
    low, high = percentile_interval(resampled, 0.95)
    moved = scores[scores["outcome_true"] == "moved"]
    iou = ious(moved)
    iou = iou[np.isfinite(iou)]
    ends = percentile_interval(resampling_counts(len(iou), RESAMPLES, rng) @ iou / len(iou), 0.95) if len(iou) else (np.nan, np.nan)
    return dict(
        n=len(scores),
        **{f"n_{outcome}": len(found) for outcome, found in groups.items()},
        accuracy=float(np.mean([found.mean() for found in there])),
        ci_low=low,
        ci_high=high,
        **{f"recall_{outcome}": float(found.mean()) if len(found) else np.nan for outcome, found in groups.items()},
        mean_iou=float(iou.mean()) if len(iou) else np.nan,
        iou_ci_low=ends[0],
        iou_ci_high=ends[1],
        median_iou=float(np.median(iou)) if len(iou) else np.nan,
        pooled_iou=float(moved["intersection"].sum() / max(1, moved["union"].sum())) if len(moved) else np.nan,
    )


def write_summary(mask_scores: Path, out: Path, config: Config) -> None:
    """A row per model and test set."""
    rows = []
    for (model, test_set), scores in read_table("mask_scores", mask_scores).groupby(["model", "test_set"], sort=False):
        rows.append(dict(model=model, test_set=test_set, **summarised(scores, generator(config.seed, "masks", "summary", model, test_set))))
    write_table("mask_summary", pd.DataFrame(rows), out, config)
