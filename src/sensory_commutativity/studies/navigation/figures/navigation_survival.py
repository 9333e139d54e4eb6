"""How many runs have not yet learned the task: Kaplan-Meier curves of the steps to the threshold return."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ....statistics.survival import median_time
from ...config import Config
from ...declarations import figure
from ...plotting import SPACE_COLOURS, SPACE_LINES, p_text
from ..tables.navigation_comparisons import LOG_RANK


@figure(
    title="How many runs have not yet learned the task: Kaplan-Meier curves of the steps to the threshold return",
    inputs=["navigation_survival", "navigation_scores", "navigation_comparisons"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_survival(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    navigation = config.navigation
    curves, scores, tests = (
        tables["navigation_survival"],
        tables["navigation_scores"],
        tables["navigation_comparisons"],
    )
    figure, axes = plt.subplots(figsize=(8.6, 4.8))
    for action_space in navigation.action_spaces:
        curve = curves[curves["action_space"] == action_space]
        end = pd.concat([curve, curve.tail(1).assign(step=navigation.steps)])
        steps, colour = end["step"] / 1000, SPACE_COLOURS[action_space]
        axes.fill_between(
            steps, end["ci_low"], end["ci_high"], step="post", color=colour, alpha=0.1, linewidth=0
        )
        half = median_time(curve["step"], curve["survival"])
        median = "median not reached" if np.isnan(half) else f"median {half / 1000:.0f}k"
        runs = scores[scores["action_space"] == action_space]
        label = f"{action_space}: {int(runs['reached'].sum())} of {len(runs)} reached it, {median}"
        axes.step(
            steps,
            end["survival"],
            where="post",
            color=colour,
            linestyle=SPACE_LINES[action_space],
            linewidth=1.8,
            label=label,
        )
        censored = int((~runs["reached"]).sum())
        if censored:
            axes.plot(
                navigation.steps / 1000,
                end["survival"].iloc[-1],
                marker="|",
                markersize=10,
                color=colour,
                clip_on=False,
            )
    ranked = tests[(tests["test"] == LOG_RANK) & (tests["family"] == "paper")]
    said = "\n".join(
        f"{row['a']} − {row['b']}: {p_text(row['p_adjusted'])}" for _, row in ranked.iterrows()
    )
    axes.text(
        1.02,
        0.02,
        f"log-rank tests, Holm:\n{said}",
        transform=axes.transAxes,
        fontsize=8,
        va="bottom",
    )
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
