"""The SCP of every degree of freedom of the gallery: a panel per robot, a mark per scene."""

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
from ..builders import gallery

COLUMNS = 3


@figure(
    title="SCP of the gallery of robots",
    inputs=["robot_gallery"],
    settings=lambda config: gallery(config),
)
def robot_gallery(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Small multiples: a row per degree of freedom, in the order of the robot's description."""
    settings = gallery(config)
    table = tables["robot_gallery"]
    table = table[table["threshold"] == settings.thresholds[0]]
    names = [name for name in settings.robots if name in set(table["robot"])]
    lines = math.ceil(len(names) / COLUMNS)
    dofs = {name: table[table["robot"] == name]["dof"].nunique() for name in names}
    most = [max(dofs[name] for name in names[i : i + COLUMNS])
            for i in range(0, len(names), COLUMNS)]  # fmt: skip
    heights = [0.7 + 0.19 * n for n in most]
    drawn, grid = plt.subplots(
        lines, COLUMNS, figsize=(12, sum(heights) + 1.0), squeeze=False, sharex=True,
        gridspec_kw={"height_ratios": heights},
    )  # fmt: skip
    for axes in grid.ravel():
        axes.set_visible(False)
    for axes, name in zip(grid.ravel(), names, strict=False):
        _draw(axes, table[table["robot"] == name], list(settings.scenes))
        axes.set_title(name, fontsize=9)
    for i in range(min(COLUMNS, len(names))):  # the lowest panel of each column
        lowest = grid[(len(names) - 1 - i) // COLUMNS, (len(names) - 1 - i) % COLUMNS]
        lowest.tick_params(labelbottom=True)
        lowest.set_xlabel("SCP")
    handles = [
        Line2D([], [], color=_colour(k), marker="o", linestyle="", label=scene)
        for k, scene in enumerate(settings.scenes)
    ]
    handles.append(
        Line2D([], [], color=GREY, marker="x", linestyle="",
               label="own body or a stop in over 1 % of the experiments in that scene")
    )  # fmt: skip
    drawn.legend(handles=handles, loc="outside upper center", ncol=3, frameon=False)
    return drawn


def _colour(k: int) -> str:
    return (VERMILION, BLUE, GREY)[k % 3]


def _draw(axes: Axes, rows: pd.DataFrame, scenes: list[str]) -> None:
    axes.set_visible(True)
    dofs = list(dict.fromkeys(rows["dof"]))
    for k, scene in enumerate(scenes):
        part = rows[rows["scene"] == scene].set_index("dof").loc[dofs]
        y = np.arange(len(dofs)) + 0.16 * (k - (len(scenes) - 1) / 2)
        axes.errorbar(
            part["scp"], y,
            xerr=error_lengths(part["scp"], part["ci_low"], part["ci_high"]),
            fmt="o", color=_colour(k), markersize=4, elinewidth=1,
        )  # fmt: skip
        spoiled = ((part["at_stop"] > 0.01) | (part["self_contact"] > 0.01)).to_numpy()
        axes.plot(part["scp"][spoiled], y[spoiled], "x", color=GREY, markersize=7)
    axes.set_yticks(range(len(dofs)), dofs)
    axes.tick_params(axis="y", labelsize=7)
    axes.set_ylim(len(dofs) - 0.4, -0.6)
    axes.set_xlim(-0.04, 1.04)
    axes.grid(axis="x", alpha=0.3)
