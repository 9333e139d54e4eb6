"""SCP of every degree of freedom of the robots (paper, Fig. "iGibson", right, and appendix C)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import draw_bars, group_colours, set_probability_axis
from ..builders import described_files, load_named_robot
from ..config import ApartmentConfig

if TYPE_CHECKING:
    from ....worlds.apartment.robots.robot import Robot


def _panels(settings: ApartmentConfig) -> list[tuple[str, str, str]]:
    """(robot, scene, start) of each panel."""
    compared, within = settings.robots_compared, settings.within_reach
    panels = [(settings.reference.robot, settings.reference.scene, "anywhere")]
    panels += [(robot, scene, "anywhere") for robot in compared.robots for scene in compared.scenes]
    panels += [(robot, scene, "within-reach") for robot in within.robots for scene in within.scenes]
    return panels


@figure(
    title="SCP of every degree of freedom of the robots in the apartments",
    inputs=["apartment_scp"],
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_scp(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A panel of bars per robot, apartment and kind of start."""
    settings = config.apartment
    threshold, view = settings.reference.threshold, settings.fields_of_view[0]
    table = tables["apartment_scp"]
    table = table[
        (table["threshold"] == threshold)
        & (table["length"] == settings.sequence_length)
        & (table["field_of_view"] == view)
    ]
    panels = _panels(settings)
    n_columns = 2 if len(panels) == 4 else min(3, len(panels))
    n_rows = math.ceil(len(panels) / n_columns)
    size = (5.4 * n_columns, 3.9 * n_rows)
    figure, grid = plt.subplots(n_rows, n_columns, figsize=size, squeeze=False)
    for axes in grid.flat[len(panels) :]:
        axes.set_axis_off()
    for axes, (name, scene, start) in zip(grid.flat, panels, strict=False):
        rows = table[
            (table["robot"] == name) & (table["apartment"] == scene) & (table["start"] == start)
        ]
        _draw_robot(axes, rows, load_named_robot(settings, name))
        where = "started anywhere"
        if start == "within-reach":
            where = f"started with something within {100 * settings.reach:g} cm of the arm"
        axes.set_title(
            f"{name} in {scene}, {where}\nn = {rows['n'].iloc[0]} for each degree of freedom",
            fontsize=8.5,
        )
    colours: dict[str, str] = {}
    for name in settings.robots:
        colours |= group_colours(load_named_robot(settings, name))
    handles = [
        plt.Rectangle((0, 0), 1, 1, color=colour, label=group) for group, colour in colours.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8)
    figure.suptitle(
        f"Threshold {threshold:g}, field of view {view:g} degrees; 95 % Wilson intervals",
        fontsize=9.5,
    )
    return figure


def _draw_robot(axes: Axes, rows: pd.DataFrame, robot: Robot) -> None:
    """Draw a bar per degree of freedom of a robot, coloured by group."""
    colours, dofs = group_colours(robot), robot.description.dofs
    rows = rows.set_index("dof").loc[[dof.name for dof in dofs]]
    draw_bars(
        axes, list(rows.index), rows["scp"], rows["ci_low"], rows["ci_high"],
        [colours[dof.group] for dof in dofs], digits=2,
    )  # fmt: skip
    set_probability_axis(axes)
