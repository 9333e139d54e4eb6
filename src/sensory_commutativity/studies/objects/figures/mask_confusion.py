"""Which outcomes are taken for which: a confusion matrix per model and test set."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from ....change_detection.outcome import OUTCOMES
from ...config import Config
from ...declarations import figure
from ...plotting import MODEL_LABELS, test_set_label


@figure(
    title="Which outcomes are taken for which: a confusion matrix per model and test set",
    inputs=["mask_scores"],
    settings=lambda config: config.masks,
)
def mask_confusion(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    scores = tables["mask_scores"]
    models, test_sets = list(scores["model"].unique()), list(scores["test_set"].unique())
    figure, grid = plt.subplots(
        len(models),
        len(test_sets),
        figsize=(2.35 * len(test_sets), 2.35 * len(models)),
        squeeze=False,
    )
    for row, model in zip(grid, models, strict=True):
        for axes, test_set in zip(row, test_sets, strict=True):
            found = scores[(scores["model"] == model) & (scores["test_set"] == test_set)]
            counts = pd.crosstab(found["outcome_true"], found["outcome_predicted"]).reindex(
                index=OUTCOMES, columns=OUTCOMES, fill_value=0
            )
            share = counts.div(counts.sum(axis=1).clip(lower=1), axis=0).to_numpy()
            axes.imshow(share, cmap="cividis", vmin=0, vmax=1)
            for i in range(len(OUTCOMES)):
                for j in range(len(OUTCOMES)):
                    colour = "white" if share[i, j] < 0.55 else "black"
                    axes.text(
                        j,
                        i,
                        f"{share[i, j]:.2f}\n{counts.iloc[i, j]}",
                        ha="center",
                        va="center",
                        color=colour,
                        fontsize=7,
                    )
            axes.set_title(f"{MODEL_LABELS[model]}, {test_set_label(test_set)}", fontsize=8)
            axes.set_xticks(range(len(OUTCOMES)), OUTCOMES, fontsize=7, rotation=20)
            axes.set_yticks(range(len(OUTCOMES)), OUTCOMES, fontsize=7)
    for axes in grid[:, 0]:
        axes.set_ylabel("true outcome", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("predicted outcome", fontsize=8)
    figure.suptitle("Fraction of the true outcome, and number of tuples", fontsize=9.5)
    return figure
