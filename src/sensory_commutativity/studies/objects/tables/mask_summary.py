"""How good each model is on each test set: accuracy of the three outcomes, overlap of the masks, with intervals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ....change_detection.outcome import OUTCOMES
from ....seeding import generator
from ....statistics.aggregates import percentile_interval, resampling_counts
from ....storage.tables import read_table, write_table
from ...config import Config

RESAMPLES = 9_999


def ious(scores: pd.DataFrame) -> np.ndarray:
    """Mean intersection over union of both masks of each row in which something moved; NaN of others: float64 (n,)."""
    with np.errstate(invalid="ignore"):
        return scores[["iou_1", "iou_2"]].mean(axis=1).to_numpy()


def summarised(scores: pd.DataFrame, rng: np.random.Generator) -> dict[str, float]:
    """One row of the table mask_summary, of the scores of one model on one test set.

    Intervals: bootstrap over households, all tuples of a household together, since they share objects and places.
    """
    outcome = scores["outcome_true"].to_numpy()
    right = (outcome == scores["outcome_predicted"].to_numpy()).astype(float)
    iou = np.where(outcome == "moved", ious(scores), np.nan)
    households, counts = resampled_households(scores["household"], rng)
    with np.errstate(invalid="ignore", divide="ignore"):
        recalls = {
            name: resampled_mean(np.where(outcome == name, right, np.nan), households, counts)
            for name in OUTCOMES
        }
        accuracy, overlap = (
            np.nanmean(np.stack(list(recalls.values())), axis=0),
            resampled_mean(iou, households, counts),
        )
    known, moved = np.isfinite(iou), scores[outcome == "moved"]
    recall = {
        name: float(right[outcome == name].mean()) if (outcome == name).any() else np.nan
        for name in OUTCOMES
    }
    low, high = percentile_interval(accuracy[np.isfinite(accuracy)], 0.95)
    ends = (
        percentile_interval(overlap[np.isfinite(overlap)], 0.95)
        if known.any()
        else (np.nan, np.nan)
    )
    return dict(
        n=len(scores),
        **{f"n_{name}": int((outcome == name).sum()) for name in OUTCOMES},
        accuracy=float(np.nanmean(list(recall.values()))),
        ci_low=low,
        ci_high=high,
        **{f"recall_{name}": value for name, value in recall.items()},
        mean_iou=float(iou[known].mean()) if known.any() else np.nan,
        iou_ci_low=ends[0],
        iou_ci_high=ends[1],
        median_iou=float(np.median(iou[known])) if known.any() else np.nan,
        pooled_iou=float(moved["intersection"].sum() / max(1, moved["union"].sum()))
        if len(moved)
        else np.nan,
    )


def resampled_households(
    household: pd.Series, rng: np.random.Generator
) -> tuple[list[np.ndarray], np.ndarray]:
    """Of each household the places of its rows, and how often each resample draws it: int (RESAMPLES, households)."""
    households = list(
        household.reset_index(drop=True).groupby(household.to_numpy()).indices.values()
    )
    return households, resampling_counts(len(households), RESAMPLES, rng)


def resampled_mean(
    values: np.ndarray, households: list[np.ndarray], counts: np.ndarray
) -> np.ndarray:
    """Means of `values` (n,), NaN left out, in resamples of households: float (resamples,); NaN where a resample has none."""
    sums = np.array([np.nansum(values[chosen]) for chosen in households])
    numbers = np.array([np.isfinite(values[chosen]).sum() for chosen in households])
    return (counts @ sums) / (counts @ numbers)


def write_summary(mask_scores: Path, out: Path, config: Config) -> None:
    """A row per model and test set."""
    rows = []
    for (model, test_set), scores in read_table("mask_scores", mask_scores).groupby(
        ["model", "test_set"], sort=False
    ):
        rows.append(
            dict(
                model=model,
                test_set=test_set,
                **summarised(scores, generator(config.seed, "masks", "summary", model, test_set)),
            )
        )
    write_table("mask_summary", pd.DataFrame(rows), out, config)
