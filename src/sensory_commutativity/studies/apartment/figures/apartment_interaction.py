"""SCP against how often the degree of freedom touched something, which only the simulator knows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import (
    DARK_GREY,
    GREEN,
    GREY,
    VERMILION,
    dof_label,
    error_lengths,
    group_colours,
    slant_xticks,
)
from ..builders import described_files, load_named_robot

if TYPE_CHECKING:
    from ....worlds.apartment.robots.robot import Robot

_KINDS = (
    ("touched", "touched something", VERMILION),
    ("hindered", "only its own body or a joint's limit", GREY),
    ("free", "neither", GREEN),
)
_CLOSE_X, _CLOSE_Y = 0.08, 0.035
"""Distance of points, in data coordinates, up to which they share a label. Chosen: the size of a
label."""


@figure(
    title="SCP against how often each degree of freedom touched something",
    inputs=["apartment_interaction"],
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_interaction(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """SCP against the fraction of experiments with touch; fractions by kind of contact."""
    settings = config.apartment
    reference = settings.reference
    table = tables["apartment_interaction"]
    table = table[(table["length"] == settings.sequence_length)]
    table = table[(table["robot"] == reference.robot) & (table["apartment"] == reference.scene)]
    robot = load_named_robot(settings, reference.robot)
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.8), width_ratios=[1, 1.2])
    _draw_points(left, table, robot)
    left.set_title(
        f"{reference.robot} in {reference.scene}; dotted: SCP = 1 − fraction touched",
        fontsize=9,
    )
    dofs = [dof.name for dof in robot.description.dofs]
    _draw_fractions(right, table[table["start"] == "anywhere"].set_index("dof").loc[dofs])
    right.set_title(
        f"why experiments do not commute, started anywhere; threshold {reference.threshold:g}",
        fontsize=9,
    )
    return figure


def _draw_points(axes: Axes, table: pd.DataFrame, robot: Robot) -> None:
    """Draw a point per degree of freedom and kind of start."""
    colours = group_colours(robot)
    dof_colours = {dof.name: colours[dof.group] for dof in robot.description.dofs}
    for start, marker in (("anywhere", "o"), ("within-reach", "^")):
        rows = table[table["start"] == start]
        for _, row in rows.iterrows():
            axes.errorbar(
                row["touched"],
                row["scp"],
                xerr=error_lengths([row["touched"]], [row["ci_low"]], [row["ci_high"]]),
                elinewidth=0.8,
                color=dof_colours[row["dof"]],
                marker=marker,
            )
        if start == "anywhere":
            _draw_names(axes, rows)
        if len(rows):
            label = f"{start}, n = {rows['n'].iloc[0]}"
            axes.plot([], [], color=DARK_GREY, marker=marker, linestyle="", label=label)
    axes.plot([0, 1], [1, 0], color=GREY, linewidth=0.8, linestyle=":")
    axes.set_xlim(-0.02, 1.02)
    axes.set_ylim(0, 1.12)
    axes.set_xlabel("fraction of experiments in which something was touched")
    axes.set_ylabel("SCP")
    axes.legend(title="start", loc="lower left")


def _draw_names(axes: Axes, rows: pd.DataFrame) -> None:
    """Write the names of the degrees of freedom; points close to each other share a label."""
    labels: list[tuple[float, float, list[str]]] = []
    for _, row in rows.sort_values("touched").iterrows():
        x, y, name = row["touched"], row["scp"], dof_label(row["dof"])
        for label_x, label_y, names in labels:
            if abs(label_x - x) < _CLOSE_X and abs(label_y - y) < _CLOSE_Y:
                names.append(name)
                break
        else:
            labels.append((x, y, [name]))
    for x, y, names in labels:
        text = ", ".join(names[:2]) + "".join(f",\n{name}" for name in names[2:])
        axes.annotate(
            text, (x, y), textcoords="offset points", xytext=(6, 5), fontsize=7, va="bottom"
        )


def _draw_fractions(axes: Axes, rows: pd.DataFrame) -> None:
    """Draw a stacked bar per degree of freedom: kinds of contact, and whether they commute."""
    x, bottom = np.arange(len(rows)), np.zeros(len(rows))
    for kind, name, colour in _KINDS:
        n, commuted = rows[f"n_{kind}"] / rows["n"], rows[f"commuted_{kind}"] / rows["n"]
        style: dict[str, Any] = dict(color=colour, width=0.75)
        axes.bar(x, n - commuted, bottom=bottom, label=f"{name}: does not commute", **style)
        middle = bottom + n - commuted
        axes.bar(x, commuted, bottom=middle, alpha=0.35, label=f"{name}: commutes", **style)
        bottom = bottom + n.to_numpy()
    slant_xticks(axes, [dof_label(dof) for dof in rows.index])
    axes.set_ylabel("fraction of experiments")
    axes.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
