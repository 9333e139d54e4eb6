"""Differences between the action spaces, pair by pair: a forest plot."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, DARK_GREY, GREY, MEASURE_LABELS, format_p_value
from ..tables.navigation_comparisons import HOWELL, MANN_WHITNEY, STEPS, WELCH, pairs

_DISAGREES = "†"


@figure(
    title="Differences between the action spaces, with intervals and tests",
    inputs=["navigation_comparisons"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_comparisons(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Three panels of differences of means, and one of the probability of improvement."""
    table, alpha = tables["navigation_comparisons"], config.navigation.alpha
    order = pairs(config)
    figure, grid = plt.subplots(1, 4, figsize=(14, 0.42 * len(order) + 2.4), sharey=True)
    for axes, measure in zip(grid, ("final_return", "auc", STEPS), strict=False):
        panel = _Panel(axes, table, measure, order, alpha)
        unit = 1000 if measure == STEPS else 1
        panel.draw_intervals(HOWELL, 1.2, unit)
        panel.draw_intervals(WELCH, 3.6, unit)
        panel.draw_points(WELCH, "difference", unit, 0.0)
        left, right = axes.get_xlim()
        axes.set_xlim(left, right + 0.2 * (right - left))
        axes.set_xlabel(f"difference in\n{MEASURE_LABELS[measure]}")
    panel = _Panel(grid[3], table, STEPS, order, alpha)
    panel.draw_intervals(MANN_WHITNEY, 3.6, 1)
    panel.draw_points(MANN_WHITNEY, "effect_size", 1, 0.5)
    grid[3].set_xlim(-0.03, 1.03)
    grid[3].set_xlabel("probability that a run of the first\nreaches the threshold sooner")
    n_paper = sum(family == "paper" for family, _, _ in order)
    if n_paper < len(order):
        for axes in grid:
            axes.axhline(n_paper - 0.5, color=GREY, linewidth=0.6, linestyle=":")
    grid[0].set_yticks(np.arange(len(order)), [f"{a} − {b}" for _, a, b in order])
    figure.suptitle(
        f"Differences between action spaces, n = {len(config.navigation.seeds)} runs each. Thick: "
        "95 % Welch interval (right: bootstrap); thin: Games-Howell, 95 % for all pairs of a "
        "family together\n"
        "p of Welch's test (right: Mann-Whitney), adjusted by Holm within the paper's three pairs "
        "(above the line) and the others (below); "
        f"filled: p < {alpha:g}; {_DISAGREES}: another test disagrees",
        fontsize=9.5,
    )
    return figure


class _Panel:
    """A panel with a line per pair, from the top, for one measure."""

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

    def _rows(self, test: str) -> pd.DataFrame:
        """Rows of a test, in the order of the pairs."""
        rows = self.table[self.table["test"] == test]
        return rows.set_index(["family", "a", "b"]).loc[self.order]

    def draw_intervals(self, test: str, width: float, unit: float) -> None:
        """Draw the interval of each pair as a grey line."""
        rows = self._rows(test)
        style: dict[str, Any] = dict(color=GREY, linewidth=width, solid_capstyle="butt", zorder=2)
        for y, ends in enumerate(zip(rows["ci_low"] / unit, rows["ci_high"] / unit, strict=True)):
            self.axes.plot(ends, [y, y], **style)

    def draw_points(self, test: str, column: str, unit: float, neutral: float) -> None:
        """Draw `column` of each pair, filled if significant, and write the p-value."""
        rows = self._rows(test)
        for y, (pair, row) in enumerate(rows.iterrows()):
            significant = row["p_adjusted"] < self.alpha
            colour = BLUE if significant else DARK_GREY
            fill = colour if significant else "white"
            style: dict[str, Any] = dict(marker="o", markersize=5, zorder=3)
            self.axes.plot(row[column] / unit, y, color=colour, markerfacecolor=fill, **style)
            text = format_p_value(row["p_adjusted"])
            if test == WELCH and self._disagrees(*pair[1:]):
                text += f" {_DISAGREES}"
            transform = self.axes.get_yaxis_transform()
            style = dict(fontsize=7, ha="right", va="center", color=colour, transform=transform)
            self.axes.text(1.0, y - 0.33, text, **style)
        self.axes.axvline(neutral, color="black", linewidth=0.8, zorder=1)
        self.axes.set_ylim(len(rows) - 0.5, -0.7)

    def _disagrees(self, a: str, b: str) -> bool:
        """Whether any other test decides otherwise than Welch's."""
        agrees = self.table.loc[(self.table["a"] == a) & (self.table["b"] == b), "agrees"]
        return bool((agrees == "no").any())
