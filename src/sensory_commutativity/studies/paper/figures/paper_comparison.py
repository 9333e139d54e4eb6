"""The paper's claims beside what this run measured, as a table to look at."""

from __future__ import annotations

import textwrap

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import DARK_GREY, GREEN, GREY, ORANGE, VERMILION

_COLUMNS = (
    (0.0, "the paper says", 46),
    (0.31, "section", 10),
    (0.37, "its value", 18),
    (0.51, "this run", 60),
)
"""Position, name and width in characters of each column of text."""
_VERDICT = 0.955
"""Position of the last column."""
_LINE = 0.24
"""Height of a line, inches."""
_RULE_WIDTH = 84
"""Characters in a line of the rule and its limits, which are smaller."""
_COLOURS = {
    "holds": GREEN, "holds in part": ORANGE, "not shown": DARK_GREY, "does not hold": VERMILION
}  # fmt: skip


@figure(title="The paper's claims and what this run measured", inputs=["paper_comparison"])
def paper_comparison(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A row per claim; below what was measured, the rule that decides and what it does not show."""
    table = tables["paper_comparison"]
    rows = [_wrap_cells(row) for _, row in table.iterrows()]
    rules = [_wrap_rule(row) for _, row in table.iterrows()]
    heights = [
        1.4 + 0.75 * max(*(text.count("\n") for text in row[:-1]), _lines(row[-1], rule) - 1)
        for row, rule in zip(rows, rules, strict=True)
    ]
    total = sum(heights) + 3
    figure = plt.figure(figsize=(13, _LINE * total))
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(total, 0)
    for x, name, _ in _COLUMNS:
        axes.text(x, 1, name, fontweight="bold", va="top")
    axes.text(_VERDICT, 1, "verdict", fontweight="bold", va="top", ha="center")
    y = 2.4
    verdicts = [_verdict(row) for _, row in table.iterrows()]
    for row, rule, verdict, height in zip(rows, rules, verdicts, heights, strict=True):
        axes.axhline(y - 0.2, color=GREY, linewidth=0.4)
        for (x, _, _), text in zip(_COLUMNS, row, strict=True):
            axes.text(x, y, text, va="top", linespacing=1.15)
        axes.text(
            _COLUMNS[-1][0], y + 0.75 * (row[-1].count("\n") + 1) + 0.1, rule, va="top",
            fontsize=7, color=DARK_GREY, linespacing=1.15,
        )  # fmt: skip
        axes.text(
            _VERDICT, y, verdict, va="top", ha="center", fontweight="bold",
            color=_COLOURS[verdict],
        )  # fmt: skip
        y += height
    return figure


def _wrap_cells(row: pd.Series) -> list[str]:
    """Texts of a row of the table, cut into lines of the width of their columns."""
    interval = "" if np.isnan(row["ci_low"]) else f" [{row['ci_low']:.4f}, {row['ci_high']:.4f}]"
    cells = (row["claim"], row["section"], row["paper_value"], row["our_value"] + interval)
    return [textwrap.fill(text, width) for text, (_, _, width) in zip(cells, _COLUMNS, strict=True)]


def _wrap_rule(row: pd.Series) -> str:
    """The rule of a claim and its limits, cut into lines; empty in tables of earlier versions."""
    parts = [
        f"{name}: {row[key]}"
        for name, key in (("Rule", "rule"), ("Limits", "limits"))
        if isinstance(row[key], str) and row[key]
    ]
    return "\n".join(textwrap.fill(part, _RULE_WIDTH) for part in parts)


def _lines(measured: str, rule: str) -> float:
    """Height of what was measured and the rule below it, in lines of the former."""
    return measured.count("\n") + 1 + (0.85 * (rule.count("\n") + 1) + 0.3 if rule else 0)


def _verdict(row: pd.Series) -> str:
    """The verdict; tables of earlier versions say only whether a claim holds."""
    if isinstance(row["verdict"], str):
        return row["verdict"]
    return "holds" if row["holds"] else "does not hold"
