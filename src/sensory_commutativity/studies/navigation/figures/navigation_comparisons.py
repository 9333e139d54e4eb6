"""Differences between the action spaces, pair by pair: a forest plot."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, MEASURE_LABELS, p_text
from ..tables.navigation_comparisons import HOWELL, STEPS, WELCH, pairs

_DISAGREES = "†"


class _Panel:
    """The pairs on one axis, from the top."""

    def __init__(
        self,
        axes: Axes,
        table: pd.DataFrame,
        measure: str,
        order: list[tuple[str, str, str]],
        alpha: float,
    ):
        self.axes, self.order, self.alpha = axes, order, alpha
        self.table = table[table["measure"] == measure]
        self.unit = 1000 if measure == STEPS else 1

    def rows(self, test: str) -> pd.DataFrame:
        return (
            self.table[self.table["test"] == test].set_index(["family", "a", "b"]).loc[self.order]
        )

    def intervals(self, rows: pd.DataFrame, width: float, unit: float) -> None:
        for y, (low, high) in enumerate(
            zip(rows["ci_low"] / unit, rows["ci_high"] / unit, strict=True)
        ):
            self.axes.plot(
                [low, high], [y, y], color=GREY, linewidth=width, solid_capstyle="butt", zorder=2
            )

    def points(self, rows: pd.DataFrame, value: str, unit: float, neutral: float) -> None:
        for y, (pair, row) in enumerate(rows.iterrows()):
            found = row["p_adjusted"] < self.alpha
            colour = BLUE if found else "#555555"
            self.axes.plot(
                row[value] / unit,
                y,
                marker="o",
                color=colour,
                markersize=5,
                markerfacecolor=colour if found else "white",
                zorder=3,
            )
            others = self.table[(self.table["a"] == pair[1]) & (self.table["b"] == pair[2])][
                "agrees"
            ]
            said = p_text(row["p_adjusted"]) + (
                f" {_DISAGREES}" if value == "difference" and (others == "no").any() else ""
            )
            self.axes.text(
                1.0,
                y - 0.33,
                said,
                transform=self.axes.get_yaxis_transform(),
                fontsize=7,
                ha="right",
                va="center",
                color=colour,
            )
        self.axes.axvline(neutral, color="black", linewidth=0.8, zorder=1)
        self.axes.set_ylim(len(rows) - 0.5, -0.7)


@figure(
    title="Differences between the action spaces, pair by pair: a forest plot",
    inputs=["navigation_comparisons"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_comparisons(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    table, alpha = tables["navigation_comparisons"], config.navigation.alpha
    order = pairs(config)
    figure, grid = plt.subplots(1, 4, figsize=(14, 0.42 * len(order) + 2.4), sharey=True)
    for axes, measure in zip(grid, ("final_return", "auc", STEPS), strict=False):
        panel = _Panel(axes, table, measure, order, alpha)
        panel.intervals(panel.rows(HOWELL), 1.2, panel.unit)
        panel.intervals(panel.rows(WELCH), 3.6, panel.unit)
        panel.points(panel.rows(WELCH), "difference", panel.unit, 0.0)
        left, right = axes.get_xlim()
        axes.set_xlim(left, right + 0.2 * (right - left))
        axes.set_xlabel(f"difference in\n{MEASURE_LABELS[measure]}")
    panel = _Panel(grid[3], table, STEPS, order, alpha)
    panel.intervals(panel.rows("Mann-Whitney"), 3.6, 1)
    panel.points(panel.rows("Mann-Whitney"), "effect_size", 1, 0.5)
    grid[3].set_xlim(-0.03, 1.03)
    grid[3].set_xlabel("probability that a run of the first\nis sooner at the threshold")
    papers = sum(family == "paper" for family, _, _ in order)
    if papers < len(order):
        for axes in grid:
            axes.axhline(papers - 0.5, color=GREY, linewidth=0.6, linestyle=":")
    grid[0].set_yticks(np.arange(len(order)), [f"{a} − {b}" for _, a, b in order])
    figure.suptitle(
        f"Differences between action spaces, n = {len(config.navigation.seeds)} runs each. Thick: 95 % Welch interval (right: bootstrap); "
        "thin: Games-Howell, 95 % for all pairs of a family together\n"
        "p of Welch's test (right: Mann-Whitney), adjusted by Holm within the paper's three pairs (above the line) and the others (below); "
        f"filled: p < {alpha:g}; {_DISAGREES}: another test disagrees",
        fontsize=9.5,
    )
    return figure
