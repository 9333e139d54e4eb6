"""Accuracy of the outcomes and overlap of the masks, for every model on every test set."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import MODELS, test_set_names
from ..columns import MODEL, TEST_SET

RESAMPLES = 9_999
OUTCOMES = ("identical", "different", "moved")


def mean_iou_per_tuple(scores: pd.DataFrame) -> np.ndarray:
    """Mean intersection over union of both masks of each row: float64 (n,), NaN if undefined."""
    with np.errstate(invalid="ignore"):
        return scores[["iou_1", "iou_2"]].mean(axis=1).to_numpy()


def mean_iou_with_empty_masks(scores: pd.DataFrame) -> float:
    """Mean IoU of all masks, where a mask that is empty and predicted as such counts as 1.

    NaN without rows; the mask of a view in which nothing moved is empty.
    """
    both = scores[["iou_1", "iou_2"]].to_numpy(float)
    return float(np.where(np.isnan(both), 1.0, both).mean()) if len(both) else np.nan


def summarize_scores(scores: pd.DataFrame, rng: np.random.Generator) -> dict[str, float]:
    """One row of the table mask_summary, for the scores of one model on one test set.

    Intervals: bootstrap over cluttered scenes, whose tuples share objects and layouts.
    """
    from ....statistics.aggregates import percentile_interval
    from ....statistics.clusters import cluster_means, resample_clusters

    outcome = scores["outcome_true"].to_numpy()
    correct = (outcome == scores["outcome_predicted"].to_numpy()).astype(float)
    iou = np.where(outcome == "moved", mean_iou_per_tuple(scores), np.nan)
    clusters, counts = resample_clusters(scores["household"], RESAMPLES, rng)
    with np.errstate(invalid="ignore", divide="ignore"):
        recalls = [
            cluster_means(np.where(outcome == name, correct, np.nan), clusters, counts)
            for name in OUTCOMES
        ]
        accuracy = np.nanmean(np.stack(recalls), axis=0)
        overlap = cluster_means(iou, clusters, counts)
    defined, moved = np.isfinite(iou), scores[outcome == "moved"]
    recall = {
        name: float(correct[outcome == name].mean()) if (outcome == name).any() else np.nan
        for name in OUTCOMES
    }
    low, high = percentile_interval(accuracy[np.isfinite(accuracy)], 0.95)
    iou_low, iou_high = (
        percentile_interval(overlap[np.isfinite(overlap)], 0.95)
        if defined.any()
        else (np.nan, np.nan)
    )
    pooled = moved["intersection"].sum() / max(1, moved["union"].sum())
    masks = np.where((outcome == "moved")[:, None], scores[["iou_1", "iou_2"]], np.nan)
    per_mask = _mean_of_masks(masks, clusters, counts)
    return dict(
        n=len(scores),
        **{f"n_{name}": int((outcome == name).sum()) for name in OUTCOMES},
        accuracy=float(np.nanmean(list(recall.values()))),
        ci_low=low,
        ci_high=high,
        **{f"recall_{name}": value for name, value in recall.items()},
        mean_iou=float(iou[defined].mean()) if defined.any() else np.nan,
        iou_ci_low=iou_low,
        iou_ci_high=iou_high,
        median_iou=float(np.median(iou[defined])) if defined.any() else np.nan,
        pooled_iou=float(pooled) if len(moved) else np.nan,
        **dict(zip(("mask_iou", "mask_iou_low", "mask_iou_high"), per_mask, strict=True)),
        iou_with_empty=mean_iou_with_empty_masks(moved),
    )


def _mean_of_masks(
    masks: np.ndarray, clusters: list[np.ndarray], counts: np.ndarray
) -> tuple[float, float, float]:
    """Mean of the IoU of all masks that have one, float (n, 2), with its 95 % interval."""
    from ....statistics.aggregates import percentile_interval

    defined = np.isfinite(masks)
    if not defined.any():
        return np.nan, np.nan, np.nan
    sums = np.array([np.nansum(masks[rows]) for rows in clusters])
    numbers = np.array([defined[rows].sum() for rows in clusters])
    with np.errstate(invalid="ignore", divide="ignore"):
        means = (counts @ sums) / (counts @ numbers)
    return float(np.nanmean(masks)), *percentile_interval(means[np.isfinite(means)], 0.95)


def _nullable(name: str, description: str) -> Column:
    return Column(name, FLOAT, "1", description, nullable=True)


def _added(name: str, description: str) -> Column:
    return Column(name, FLOAT, "1", description, nullable=True, added=True)


@table(
    title="Accuracy and overlap of every model on every test set",
    columns=(
        MODEL,
        TEST_SET,
        Column("n", INT, "1", "test tuples"),
        Column("n_identical", INT, "1", "of them identical"),
        Column("n_different", INT, "1", "of them different"),
        Column("n_moved", INT, "1", "of them with an object that moved"),
        _nullable("accuracy", "mean of the recalls of the three outcomes (balanced accuracy)"),
        *INTERVAL,
        _nullable("recall_identical", "fraction of the identical that is predicted as such"),
        _nullable("recall_different", "of the different"),
        _nullable("recall_moved", "of those in which something moved"),
        _nullable("mean_iou", "mean over tuples of the mean IoU of both masks"),
        _nullable("iou_ci_low", "lower end of its 95 % interval"),
        _nullable("iou_ci_high", "upper end"),
        _nullable("median_iou", "median over tuples"),
        _nullable("pooled_iou", "sum of all intersections over sum of all unions"),
        _added("mask_iou", "mean over masks, the paper's IoU_i: of those that are not both empty"),
        _added("mask_iou_low", "lower end of its 95 % interval"),
        _added("mask_iou_high", "upper end"),
        _added("iou_with_empty", "mean over masks, both empty counting as 1"),
    ),
    inputs=["mask_scores"],
    expected=lambda config: Expected(
        ("model", "test_set"),
        {(model, name): 1 for model in MODELS for name in test_set_names(config)},
    ),
)
def mask_summary(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per model and test set."""
    rows = []
    for (model, test_set), group in scores.groupby(["model", "test_set"], sort=False):
        rng = generator(config.seed, "masks", "summary", model, test_set)
        rows.append(dict(model=model, test_set=test_set, **summarize_scores(group, rng)))
    return pd.DataFrame(rows)
