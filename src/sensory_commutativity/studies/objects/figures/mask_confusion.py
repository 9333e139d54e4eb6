"""Confusion matrix of the three outcomes, for every model and test set."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import MODEL_LABELS, label_test_set
from ..tables.mask_summary import OUTCOMES


@figure(
    title="Confusion matrices of the three outcomes",
    inputs=["mask_scores"],
    settings=lambda config: config.masks,
)
def mask_confusion(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A matrix per model (row) and test set (column)."""
    scores = tables["mask_scores"]
    models, test_sets = list(scores["model"].unique()), list(scores["test_set"].unique())
    size = (2.35 * len(test_sets), 2.35 * len(models))
    figure, grid = plt.subplots(len(models), len(test_sets), figsize=size, squeeze=False)
    for row, model in zip(grid, models, strict=True):
        for axes, test_set in zip(row, test_sets, strict=True):
            chosen = (scores["model"] == model) & (scores["test_set"] == test_set)
            _draw_matrix(axes, scores[chosen])
            axes.set_title(f"{MODEL_LABELS[model]}, {label_test_set(test_set)}", fontsize=8)
    for axes in grid[:, 0]:
        axes.set_ylabel("true outcome", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("predicted outcome", fontsize=8)
    figure.suptitle("Fraction of the true outcome, and number of tuples", fontsize=9.5)
    return figure


def _draw_matrix(axes: Axes, scores: pd.DataFrame) -> None:
    counts = pd.crosstab(scores["outcome_true"], scores["outcome_predicted"])
    counts = counts.reindex(index=OUTCOMES, columns=OUTCOMES, fill_value=0)
    fraction = counts.div(counts.sum(axis=1).clip(lower=1), axis=0).to_numpy()
    axes.imshow(fraction, cmap="cividis", vmin=0, vmax=1)
    for i, j in np.ndindex(fraction.shape):
        colour = "white" if fraction[i, j] < 0.55 else "black"
        text = f"{fraction[i, j]:.2f}\n{counts.iloc[i, j]}"
        axes.text(j, i, text, ha="center", va="center", color=colour, fontsize=7)
    axes.set_xticks(range(len(OUTCOMES)), OUTCOMES, fontsize=7, rotation=20)
    axes.set_yticks(range(len(OUTCOMES)), OUTCOMES, fontsize=7)
