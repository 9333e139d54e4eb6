"""Fraction of runs that have not yet learned the task: Kaplan-Meier curves of the steps to the
threshold return."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import SPACE_COLOURS, SPACE_LINES, format_p_value
from ..tables.navigation_comparisons import LOG_RANK


@figure(
    title="Fraction of runs that have not yet learned the task (Kaplan-Meier)",
    inputs=["navigation_survival", "navigation_scores", "navigation_comparisons"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_survival(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A step curve per action space, and the log-rank tests of the paper's pairs."""
    navigation = config.navigation
    curves, scores = tables["navigation_survival"], tables["navigation_scores"]
    figure, axes = plt.subplots(figsize=(8.6, 4.8))
    for action_space in navigation.action_spaces:
        curve = curves[curves["action_space"] == action_space]
        runs = scores[scores["action_space"] == action_space]
        _draw_curve(axes, curve, runs, action_space, navigation.steps)
    tests = tables["navigation_comparisons"]
    tests = tests[(tests["test"] == LOG_RANK) & (tests["family"] == "paper")]
    lines = ["log-rank tests, Holm:"]
    for _, row in tests.iterrows():
        lines.append(f"{row['a']} − {row['b']}: {format_p_value(row['p_adjusted'])}")
    axes.text(1.02, 0.02, "\n".join(lines), transform=axes.transAxes, fontsize=8, va="bottom")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axes.set_ylim(0, 1.02)
    axes.set_yticks(np.linspace(0, 1, 6))
    axes.set_xlim(0, navigation.steps / 1000)
    axes.set_xlabel("environment steps of training (thousands)")
    axes.set_ylabel(f"runs that have not reached a mean return of {navigation.threshold_return:g}")
    axes.set_title(
        "Kaplan-Meier estimates, pointwise 95 % intervals; a bar at the end: censored runs",
        fontsize=9.5,
        loc="left",
    )
    return figure


def _draw_curve(
    axes: Axes, curve: pd.DataFrame, runs: pd.DataFrame, action_space: str, last_step: int
) -> None:
    """Draw the curve of an action space, with a bar at `last_step` if runs are censored."""
    from ....statistics.survival import median_time  # imports scipy

    extended = pd.concat([curve, curve.tail(1).assign(step=last_step)])
    steps, colour = extended["step"] / 1000, SPACE_COLOURS[action_space]
    axes.fill_between(
        steps, extended["ci_low"], extended["ci_high"], step="post", color=colour, alpha=0.1,
        linewidth=0,
    )  # fmt: skip
    half = median_time(curve["step"], curve["survival"])
    median = "median not reached" if np.isnan(half) else f"median {half / 1000:.0f}k"
    n_reached = int(runs["reached"].sum())
    axes.step(
        steps, extended["survival"], where="post", color=colour,
        linestyle=SPACE_LINES[action_space], linewidth=1.8,
        label=f"{action_space}: {n_reached} of {len(runs)} reached it, {median}",
    )  # fmt: skip
    if n_reached < len(runs):
        end = extended["survival"].iloc[-1]
        axes.plot(last_step / 1000, end, marker="|", markersize=10, color=colour, clip_on=False)
