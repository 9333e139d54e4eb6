"""The paper's claims beside what this run measured, as a table to look at."""

from __future__ import annotations

import textwrap

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import GREEN, GREY, VERMILION

_COLUMNS = (
    (0.0, "the paper says", 58),
    (0.40, "section", 10),
    (0.47, "its value", 18),
    (0.62, "this run", 60),
)
"""Position, name and width in characters of each column of text."""
_HOLDS = 0.97
"""Position of the last column."""
_LINE = 0.24
"""Height of a line, inches."""


@figure(title="The paper's claims and what this run measured", inputs=["paper_comparison"])
def paper_comparison(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A row per claim."""
    table = tables["paper_comparison"]
    rows = [_wrap_cells(row) for _, row in table.iterrows()]
    heights = [1.4 + 0.75 * max(text.count("\n") for text in row) for row in rows]
    total = sum(heights) + 3
    figure = plt.figure(figsize=(13, _LINE * total))
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(total, 0)
    for x, name, _ in _COLUMNS:
        axes.text(x, 1, name, fontweight="bold", va="top")
    axes.text(_HOLDS, 1, "holds", fontweight="bold", va="top", ha="center")
    y = 2.4
    for row, holds, height in zip(rows, table["holds"], heights, strict=True):
        axes.axhline(y - 0.2, color=GREY, linewidth=0.4)
        for (x, _, _), text in zip(_COLUMNS, row, strict=True):
            axes.text(x, y, text, va="top", linespacing=1.15)
        text, colour = ("yes", GREEN) if holds else ("no", VERMILION)
        axes.text(_HOLDS, y, text, va="top", ha="center", fontweight="bold", color=colour)
        y += height
    return figure


def _wrap_cells(row: pd.Series) -> list[str]:
    """Texts of a row of the table, cut into lines of the width of their columns."""
    interval = "" if np.isnan(row["ci_low"]) else f" [{row['ci_low']:.4f}, {row['ci_high']:.4f}]"
    cells = (row["claim"], row["section"], row["paper_value"], row["our_value"] + interval)
    return [textwrap.fill(text, width) for text, (_, _, width) in zip(cells, _COLUMNS, strict=True)]
