"""How well masks fit: the distribution of the intersection over union, and its mean with the accuracy beside it."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLACK, BLUE, GREY, MODEL_LABELS, VERMILION, test_set_label
from ..claims import ACCURACY, IOU, IOU_UNSEEN
from ..tables.mask_summary import ious

MODEL_STYLES = {
    "raft": (VERMILION, "-", "o"),
    "flownet": (BLUE, "--", "s"),
    "difference": (GREY, ":", "^"),
}
PAPER = {"as-trained": (IOU, ACCURACY), "all-other": (IOU_UNSEEN, None)}


@figure(
    title="How well masks fit: the distribution of the intersection over union, and its mean with the accuracy beside it",
    inputs=["mask_scores", "mask_summary"],
    settings=lambda config: config.masks,
)
def mask_iou(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    scores, summary = tables["mask_scores"], tables["mask_summary"]
    test_sets = list(summary["test_set"].unique())
    figure, grid = plt.subplots(
        2, len(test_sets), figsize=(2.7 * len(test_sets), 5.6), squeeze=False, sharey="row"
    )
    for column, test_set in zip(grid.T, test_sets, strict=True):
        upper, lower = column
        n_moved = 0
        for x, model in enumerate(summary["model"].unique()):
            colour, line, marker = MODEL_STYLES[model]
            rows = scores[
                (scores["model"] == model)
                & (scores["test_set"] == test_set)
                & (scores["outcome_true"] == "moved")
            ]
            found = np.sort(ious(rows)[np.isfinite(ious(rows))])
            upper.plot(
                found,
                1 - np.arange(len(found)) / max(1, len(found)),
                color=colour,
                linestyle=line,
                label=MODEL_LABELS[model],
            )
            n_moved = max(n_moved, len(found))
            row = summary[(summary["model"] == model) & (summary["test_set"] == test_set)].iloc[0]
            for dx, (value, low, high, filled) in enumerate(
                (
                    (row["mean_iou"], row["iou_ci_low"], row["iou_ci_high"], True),
                    (row["accuracy"], row["ci_low"], row["ci_high"], False),
                )
            ):
                lower.errorbar(
                    x + 0.3 * dx, value, yerr=[[max(0, value - low)], [max(0, high - value)]], color=colour, marker=marker, markersize=6,
                    markerfacecolor=colour if filled else "white", capsize=3, linestyle="none",
                )  # fmt: skip
                lower.annotate(
                    f"{value:.2f}",
                    (x + 0.3 * dx, value),
                    textcoords="offset points",
                    xytext=(0, 9),
                    ha="center",
                    fontsize=7,
                )
        for value, name, side in zip(
            PAPER.get(test_set, ()), ("IoU", "accuracy"), (1, -1), strict=False
        ):
            if value is not None:
                lower.axhline(value, color=BLACK, linewidth=0.8, linestyle=":")
                lower.text(
                    1.68,
                    value + 0.008 * side,
                    f"paper, {name}",
                    fontsize=6.5,
                    ha="center",
                    va="bottom" if side > 0 else "top",
                )
        upper.set_title(f"{test_set_label(test_set)} (n = {n_moved} that moved)", fontsize=8)
        upper.set_xlabel("intersection over union")
        upper.legend(fontsize=7, loc="lower left", framealpha=1)
        models = summary["model"].unique()
        lower.set_xticks(
            np.arange(len(models)) + 0.15,
            [MODEL_LABELS[model].replace(" ", "\n") for model in models],
            fontsize=7,
        )
        lower.set_xlim(-0.4, len(models) - 0.3)
    grid[0, 0].set_ylabel("fraction of tuples above")
    grid[1, 0].set_ylabel("mean IoU (filled), accuracy (open)\n95 % intervals")
    grid[1, 0].set_ylim(0, 1.08)
    return figure
