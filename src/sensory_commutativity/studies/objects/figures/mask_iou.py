"""Overlap of predicted and true masks: the distribution of the intersection over union, and its
mean beside the accuracy."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import (
    BLACK,
    MODEL_LABELS,
    MODEL_STYLES,
    annotate_above,
    error_lengths,
    label_test_set,
)
from ..claims import ACCURACY, IOU, IOU_UNSEEN
from ..tables.mask_summary import mean_iou_per_tuple

PAPER = {"as-trained": {"IoU": IOU, "accuracy": ACCURACY}, "all-other": {"IoU": IOU_UNSEEN}}
"""Test set -> the paper's values."""


@figure(
    title="Overlap of predicted and true masks, and accuracy of the outcomes",
    inputs=["mask_scores", "mask_summary"],
    settings=lambda config: config.masks,
)
def mask_iou(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A column per test set: the distribution of the IoU above, the means below."""
    scores, summary = tables["mask_scores"], tables["mask_summary"]
    test_sets = list(summary["test_set"].unique())
    figure, grid = plt.subplots(
        2, len(test_sets), figsize=(2.7 * len(test_sets), 5.6), squeeze=False, sharey="row"
    )
    for (upper, lower), test_set in zip(grid.T, test_sets, strict=True):
        moved = scores[(scores["test_set"] == test_set) & (scores["outcome_true"] == "moved")]
        rows = summary[summary["test_set"] == test_set].set_index("model")
        _draw_distributions(upper, moved, list(rows.index), label_test_set(test_set))
        _draw_means(lower, rows)
        _draw_paper_values(lower, PAPER.get(test_set, {}))
    grid[0, 0].set_ylabel("fraction of tuples above")
    grid[1, 0].set_ylabel("mean IoU (filled), accuracy (open)\n95 % intervals")
    grid[1, 0].set_ylim(0, 1.08)
    return figure


def _draw_distributions(axes: Axes, moved: pd.DataFrame, models: list[str], name: str) -> None:
    """Draw the fraction of tuples above each IoU, a curve per model."""
    n_moved = 0
    for model in models:
        colour, line, _ = MODEL_STYLES[model]
        iou = mean_iou_per_tuple(moved[moved["model"] == model])
        iou = np.sort(iou[np.isfinite(iou)])
        above = 1 - np.arange(len(iou)) / max(1, len(iou))
        axes.plot(iou, above, color=colour, linestyle=line, label=MODEL_LABELS[model])
        n_moved = max(n_moved, len(iou))
    axes.set_title(f"{name} (n = {n_moved} that moved)", fontsize=8)
    axes.set_xlabel("intersection over union")
    axes.legend(fontsize=7, loc="lower left", framealpha=1)


def _draw_means(axes: Axes, rows: pd.DataFrame) -> None:
    """Draw mean IoU and accuracy of each model; `rows` are those of a test set, by model."""
    for x, (model, row) in enumerate(rows.iterrows()):
        colour, _, marker = MODEL_STYLES[model]
        style: dict[str, Any] = dict(color=colour, marker=marker, markersize=6, capsize=3)
        for dx, fill, columns in (
            (0.0, colour, ["mean_iou", "iou_ci_low", "iou_ci_high"]),
            (0.3, "white", ["accuracy", "ci_low", "ci_high"]),
        ):
            value, low, high = row[columns]
            error = error_lengths([value], [low], [high])
            style |= dict(markerfacecolor=fill, linestyle="none")
            axes.errorbar(x + dx, value, yerr=error, **style)
            annotate_above(axes, x + dx, value, f"{value:.2f}", 7, gap=9)
    labels = [MODEL_LABELS[model].replace(" ", "\n") for model in rows.index]
    axes.set_xticks(np.arange(len(rows)) + 0.15, labels, fontsize=7)
    axes.set_xlim(-0.4, len(rows) - 0.3)


def _draw_paper_values(axes: Axes, values: dict[str, float]) -> None:
    """Draw a dotted line per value of the paper."""
    for name, value in values.items():
        above = name == "IoU"
        axes.axhline(value, color=BLACK, linewidth=0.8, linestyle=":")
        axes.text(
            1.68, value + (0.008 if above else -0.008), f"paper, {name}", fontsize=6.5,
            ha="center", va="bottom" if above else "top",
        )  # fmt: skip
