"""The scores of every training run, and their means."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...config import Config
from ...declarations import figure
from ...plotting import DARK_GREY, GREY, MEASURE_LABELS, SPACE_COLOURS, error_lengths, slant_xticks
from ..tables.navigation_comparisons import STEPS

_SPREAD = 0.3
"""Half of the width over which the runs of an action space are spread."""


@figure(
    title="Scores of every training run",
    inputs=["navigation_scores", "navigation_summary"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_scores(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A panel per measure, with a dot per run."""
    navigation, scores = config.navigation, tables["navigation_scores"]
    summary = tables["navigation_summary"].set_index(["action_space", "measure"])
    n = len(navigation.seeds)
    figure, grid = plt.subplots(1, 4, figsize=(14, 4.6))
    for axes, measure in zip(grid, MEASURE_LABELS, strict=True):
        for i, action_space in enumerate(navigation.action_spaces):
            runs = scores[scores["action_space"] == action_space]
            _draw_runs(axes, i, runs, summary.loc[(action_space, measure)], measure)
        slant_xticks(axes, navigation.action_spaces)
        axes.set_ylabel(MEASURE_LABELS[measure])
    _, _, success, steps = grid
    for i, action_space in enumerate(navigation.action_spaces):
        solved = int(scores.loc[scores["action_space"] == action_space, "solved"].sum())
        transform = success.get_xaxis_transform()
        success.text(i, 1.01, f"{solved}/{n}", transform=transform, ha="center", fontsize=8)
    success.set_title("runs at or above the dotted line: solved", fontsize=8.5, pad=16)
    success.axhline(navigation.solved_success_rate, color=GREY, linewidth=0.8, linestyle=":")
    threshold = navigation.threshold_return
    steps.set_title(f"threshold: a mean return of {threshold:g}", fontsize=8.5, pad=16)
    point: dict[str, Any] = dict(color=DARK_GREY, linestyle="")
    handles = [
        Line2D([], [], marker="o", alpha=0.6, label="a run", **point),
        Line2D([], [], marker="^", label="censored: not reached", markerfacecolor="none", **point),
        Line2D([], [], marker="D", color=DARK_GREY, label="mean, 95 % interval"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    figure.suptitle(f"Scores of all {n} runs of each action space")
    return figure


def _draw_runs(axes: Axes, x: float, runs: pd.DataFrame, summary: pd.Series, measure: str) -> None:
    """Draw the runs of an action space around `x`, and their mean with its interval to the right.

    Runs that did not reach the threshold are drawn as open triangles.
    """
    unit = 1000 if measure == STEPS else 1
    reached = runs["reached"].to_numpy() if measure == STEPS else np.ones(len(runs), bool)
    colour, values = SPACE_COLOURS[runs["action_space"].iloc[0]], runs[measure].to_numpy() / unit
    xs = x + _spread(len(runs))
    axes.scatter(xs[reached], values[reached], s=16, color=colour, alpha=0.55, linewidth=0)
    style: dict[str, Any] = dict(s=20, facecolor="none", edgecolor=colour, marker="^")
    axes.scatter(xs[~reached], values[~reached], **style)
    mean, low, high = summary[["mean", "mean_low", "mean_high"]] / unit
    error = error_lengths([mean], [low], [high])
    style = dict(fmt="D", color=colour, markersize=5, capsize=3, elinewidth=1.4)
    axes.errorbar(x + 0.42, mean, yerr=error, **style)


def _spread(n: int) -> np.ndarray:
    """Offsets of `n` points beside each other, float64 (n,), the same in every run of the code.

    They are the fractional parts of the multiples of the golden ratio, which are evenly spread.
    """
    return _SPREAD * 2 * ((np.arange(n) * (np.sqrt(5) - 1) / 2) % 1 - 0.5)
