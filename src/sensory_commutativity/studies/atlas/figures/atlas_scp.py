"""The SCP of every action of every environment: one small panel each."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, VERMILION, error_lengths
from ..builders import atlas, environments

COLUMNS = 4


@figure(
    title="SCP of standard environments",
    inputs=["atlas_scp"],
    settings=lambda config: atlas(config),
)
def atlas_scp(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Small multiples: a row per action, lowest SCP at the top."""
    threshold = atlas(config).main_threshold
    table = tables["atlas_scp"]
    table = table[table["threshold"] == threshold]
    names = [name for name in environments(config) if name in set(table["environment"])]
    lines = math.ceil(len(names) / COLUMNS)
    most = [max((table["environment"] == name).sum() for name in names[i : i + COLUMNS])
            for i in range(0, len(names), COLUMNS)]  # fmt: skip
    heights = [0.7 + 0.17 * n for n in most]
    drawn, grid = plt.subplots(
        lines, COLUMNS, figsize=(13, sum(heights) + 1.0), squeeze=False, sharex=True,
        gridspec_kw={"height_ratios": heights},
    )  # fmt: skip
    for axes in grid.ravel():
        axes.set_visible(False)
    for axes, name in zip(grid.ravel(), names, strict=False):
        _draw(axes, table[table["environment"] == name], name)
    for i in range(min(COLUMNS, len(names))):  # the lowest panel of each column
        lowest = grid[(len(names) - 1 - i) // COLUMNS, i]
        lowest.tick_params(labelbottom=True)
        lowest.set_xlabel("SCP")
    handles = [
        Line2D([], [], color=BLUE, marker="o", linestyle="", label="all experiments"),
        Line2D([], [], color=VERMILION, marker="|", markersize=9, linestyle="",
               label="experiments that touched nothing (control in free space)"),
        Line2D([], [], color=GREY, marker="o", linestyle="", markerfacecolor="white",
               label="all experiments, of a row that shows no effect on the world"),
    ]  # fmt: skip
    drawn.legend(handles=handles, loc="outside upper center", ncol=3, frameon=False)
    return drawn


def _draw(axes: Axes, rows: pd.DataFrame, name: str) -> None:
    axes.set_visible(True)
    rows = rows.sort_values(["scp", "area"], ascending=True)
    y = np.arange(len(rows))
    believed = ~rows["verdict"].str.startswith(("no effect", "undefined", "dead")).to_numpy()
    for chosen, colour, face in ((believed, BLUE, BLUE), (~believed, GREY, "white")):
        part = rows[chosen]
        axes.errorbar(
            part["scp"], y[chosen],
            xerr=error_lengths(part["scp"], part["ci_low"], part["ci_high"]),
            fmt="o", color=colour, markerfacecolor=face, markersize=4, elinewidth=1,
        )  # fmt: skip
    axes.plot(rows["scp_untouched"], y, "|", color=VERMILION, markersize=9)
    axes.set_yticks(y, [str(action).replace("robot0:", "") for action in rows["action"]])
    axes.tick_params(axis="y", labelsize=6.5)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlim(-0.04, 1.04)
    axes.grid(axis="x", alpha=0.3)
    axes.set_title(f"{name} ({rows['control'].iloc[0]})", fontsize=8)
