"""Every training run's scores: nothing is averaged away."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...config import Config
from ...declarations import figure
from ...plotting import MEASURE_LABELS, SPACE_COLOURS

_SPREAD = 0.3


def _spread(n: int) -> np.ndarray:
    """Places of n points beside each other, the same in every run: the golden ratio's fractional parts."""
    return _SPREAD * 2 * ((np.arange(n) * (np.sqrt(5) - 1) / 2) % 1 - 0.5)


@figure(
    title="Every training run's scores: nothing is averaged away",
    inputs=["navigation_scores", "navigation_summary"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_scores(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    navigation = config.navigation
    scores, summary = (
        tables["navigation_scores"],
        tables["navigation_summary"].set_index(["action_space", "measure"]),
    )
    figure, grid = plt.subplots(1, 4, figsize=(14, 4.6))
    for axes, measure in zip(grid, MEASURE_LABELS, strict=True):
        unit = 1000 if measure == "steps_to_threshold" else 1
        for i, action_space in enumerate(navigation.action_spaces):
            runs = scores[scores["action_space"] == action_space]
            colour = SPACE_COLOURS[action_space]
            known = runs["reached"].to_numpy() if unit > 1 else np.ones(len(runs), bool)
            places, values = i + _spread(len(runs)), runs[measure].to_numpy() / unit
            axes.scatter(places[known], values[known], s=16, color=colour, alpha=0.55, linewidth=0)
            axes.scatter(
                places[~known], values[~known], s=20, facecolor="none", edgecolor=colour, marker="^"
            )
            row = summary.loc[(action_space, measure)]
            mean, low, high = row["mean"] / unit, row["mean_low"] / unit, row["mean_high"] / unit
            axes.errorbar(
                i + 0.42,
                mean,
                yerr=[[mean - low], [high - mean]],
                fmt="D",
                color=colour,
                markersize=5,
                capsize=3,
                elinewidth=1.4,
            )
        axes.set_xticks(
            range(len(navigation.action_spaces)),
            navigation.action_spaces,
            rotation=45,
            ha="right",
            rotation_mode="anchor",
        )
        axes.set_ylabel(MEASURE_LABELS[measure])
    for i, action_space in enumerate(navigation.action_spaces):
        solved = int(scores.loc[scores["action_space"] == action_space, "solved"].sum())
        grid[2].text(
            i,
            1.01,
            f"{solved}/{len(navigation.seeds)}",
            transform=grid[2].get_xaxis_transform(),
            ha="center",
            fontsize=8,
        )
    grid[2].set_title("runs at or above the dotted line: solved", fontsize=8.5, pad=16)
    grid[2].axhline(navigation.solved_success_rate, color="#8A8A8A", linewidth=0.8, linestyle=":")
    grid[3].set_title(
        f"threshold: a mean return of {navigation.threshold_return:g}", fontsize=8.5, pad=16
    )
    handles = [
        Line2D([], [], marker="o", color="#555555", alpha=0.6, linestyle="", label="a run"),
        Line2D(
            [],
            [],
            marker="^",
            markerfacecolor="none",
            color="#555555",
            linestyle="",
            label="censored: not reached",
        ),
        Line2D([], [], marker="D", color="#555555", label="mean, 95 % interval"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    figure.suptitle(f"Scores of all {len(navigation.seeds)} runs of each action space")
    return figure
