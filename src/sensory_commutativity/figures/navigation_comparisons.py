"""Differences between the action spaces, pair by pair: a forest plot."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..config import Config
from ..stages.navigation_comparisons import ALPHA, WELCH, pairs
from .style import BLUE, GREY, MEASURE_LABELS, p_text


def _forest(axes: Axes, rows: pd.DataFrame, value: str, unit: float, neutral: float) -> None:
    for y, (_, row) in enumerate(rows.iterrows()):
        found = row["p_adjusted"] < ALPHA
        colour = BLUE if found else GREY
        axes.plot([row["ci_low"] / unit, row["ci_high"] / unit], [y, y], color=colour, linewidth=1.8)
        axes.plot(row[value] / unit, y, marker="o", color=colour, markersize=5, markerfacecolor=colour if found else "white")
        axes.text(1.0, y - 0.33, p_text(row["p_adjusted"]), transform=axes.get_yaxis_transform(), fontsize=7, ha="right", va="center", color=colour)
    axes.axvline(neutral, color="black", linewidth=0.8)
    axes.set_ylim(len(rows) - 0.5, -0.7)


def draw(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    table = tables["navigation_comparisons"]
    order = pairs(config)
    panels = [(measure, WELCH, "difference") for measure in ("final_return", "auc", "steps_to_threshold")]
    panels.append(("steps_to_threshold", "Mann-Whitney", "effect_size"))
    figure, grid = plt.subplots(1, len(panels), figsize=(14, 0.42 * len(order) + 2), sharey=True)
    for axes, (measure, test, value) in zip(grid, panels, strict=True):
        rows = table[(table["measure"] == measure) & (table["test"] == test)].set_index(["family", "a", "b"]).loc[order]
        unit = 1000 if measure == "steps_to_threshold" and value == "difference" else 1
        _forest(axes, rows, value, unit, 0.5 if value == "effect_size" else 0.0)
        label = (
            "probability that a run of the first\nis sooner at the threshold"
            if value == "effect_size"
            else f"difference in\n{MEASURE_LABELS[measure]}"
        )
        axes.set_xlabel(label)
        if value == "effect_size":
            axes.set_xlim(-0.03, 1.03)
        else:
            left, right = axes.get_xlim()
            axes.set_xlim(left, right + 0.18 * (right - left))
        papers = sum(family == "paper" for family, _, _ in order)
        if papers < len(order):
            axes.axhline(papers - 0.5, color=GREY, linewidth=0.6, linestyle=":")
    names = [f"{a} − {b}" for _, a, b in order]
    grid[0].set_yticks(np.arange(len(order)), names)
    figure.suptitle(
        f"Differences between action spaces, n = {len(config.navigation.seeds)} runs each: means, 95 % Welch intervals; right: bootstrap interval\n"
        f"p adjusted by Holm within the paper's three pairs (above the line) and within the pairs with controls (below); filled: p < {ALPHA}",
        fontsize=10,
    )
    return figure
