"""The paper's claims beside what was measured, as a table to look at."""

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
_HOLDS = 0.97
_LINE = 0.24  # inches


def _ours(row: pd.Series) -> str:
    interval = "" if np.isnan(row["ci_low"]) else f" [{row['ci_low']:.4f}, {row['ci_high']:.4f}]"
    return row["our_value"] + interval


@figure(
    title="The paper's claims beside what was measured, as a table to look at",
    inputs=["paper_comparison"],
)
def paper_comparison(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    rows = []
    for _, row in tables["paper_comparison"].iterrows():
        cells = (row["claim"], row["section"], row["paper_value"], _ours(row))
        rows.append(
            (
                [
                    textwrap.fill(text, width)
                    for text, (_, _, width) in zip(cells, _COLUMNS, strict=True)
                ],
                row["holds"],
            )
        )
    heights = [1.4 + 0.75 * max(text.count("\n") for text in cells) for cells, _ in rows]
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
    for (cells, holds), height in zip(rows, heights, strict=True):
        axes.axhline(y - 0.2, color=GREY, linewidth=0.4)
        for (x, _, _), text in zip(_COLUMNS, cells, strict=True):
            axes.text(x, y, text, va="top", linespacing=1.15)
        axes.text(
            _HOLDS,
            y,
            "yes" if holds else "no",
            va="top",
            ha="center",
            fontweight="bold",
            color=GREEN if holds else VERMILION,
        )
        y += height
    return figure
