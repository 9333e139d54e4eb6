"""Training curves of the mask models: training loss, and accuracy and IoU on validation pairs."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import MODEL_LABELS, MODEL_STYLES

_MEASURES = {
    "loss": "training loss",
    "accuracy": "accuracy of the three outcomes,\nvalidation pairs",
    "iou": "mean IoU where something moved,\nvalidation pairs",
}


@figure(
    title="Training curves of the mask models",
    inputs=["mask_curves"],
    settings=lambda config: config.masks,
)
def mask_curves(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A panel per measure, with a curve per model."""
    curves = tables["mask_curves"]
    figure, grid = plt.subplots(1, 3, figsize=(11, 3.5))
    for axes, (measure, name) in zip(grid, _MEASURES.items(), strict=True):
        for model, rows in curves.groupby("model", sort=False):
            colour, line, marker = MODEL_STYLES[model]
            axes.plot(
                rows["samples"] / 1000, rows[measure], color=colour, linestyle=line, marker=marker,
                markersize=4, label=MODEL_LABELS[model],
            )  # fmt: skip
        axes.set_xlabel("pairs shown (thousands)")
        axes.set_ylabel(name)
        if measure == "loss":
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
            axes.yaxis.set_minor_formatter("{x:g}")
        else:
            axes.set_ylim(0, 1.03)
    grid[0].legend()
    data = config.masks.data
    figure.suptitle(
        f"{3 * data.pairs:,} training pairs, {3 * data.validation_pairs:,} validation pairs; "
        "one training run each",
        fontsize=9,
    )
    return figure
