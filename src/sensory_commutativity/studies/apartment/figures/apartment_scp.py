"""SCP of every degree of freedom of the robots (paper, Fig. "iGibson", right, and appendix C)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....worlds.apartment.robots.robot import Robot, load_robot
from ...apartment.builders import described_files
from ...config import Config
from ...declarations import figure
from ...plotting import dof_label, group_colours, probability_axis, probability_text


def bars(axes: Axes, rows: pd.DataFrame, robot: Robot) -> None:
    """A bar per degree of freedom with its interval, coloured by group."""
    colours = group_colours(robot)
    dofs = [dof.name for dof in robot.description.dofs]
    rows = rows.set_index("dof").loc[dofs]
    scp, low, high = (rows[key].to_numpy() for key in ("scp", "ci_low", "ci_high"))
    axes.bar(
        range(len(dofs)),
        scp,
        color=[colours[dof.group] for dof in robot.description.dofs],
        width=0.75,
    )
    axes.errorbar(
        range(len(dofs)),
        scp,
        yerr=np.maximum(0, [scp - low, high - scp]),
        fmt="none",
        ecolor="#444444",
        elinewidth=1.2,
        capsize=2.5,
    )
    for x, (value, top) in enumerate(zip(scp, high, strict=True)):
        axes.annotate(
            probability_text(value, 2),
            (x, top),
            textcoords="offset points",
            xytext=(0, 3),
            ha="center",
            fontsize=7,
        )
    axes.set_xticks(
        range(len(dofs)),
        [dof_label(dof) for dof in dofs],
        rotation=45,
        ha="right",
        rotation_mode="anchor",
    )
    probability_axis(axes)


@figure(
    title="SCP of every degree of freedom of the robots",
    inputs=["apartment_scp"],
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_scp(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    settings = config.apartment
    table = tables["apartment_scp"]
    table = table[
        (table["threshold"] == settings.reference.threshold)
        & (table["length"] == settings.sequence_length)
    ]
    table = table[table["field_of_view"] == settings.fields_of_view[0]]
    panels = [(settings.reference.robot, settings.reference.scene, "anywhere")]
    panels += [
        (robot, scene, "anywhere")
        for robot in settings.robots_compared.robots
        for scene in settings.robots_compared.scenes
    ]
    panels += [
        (robot, scene, "within-reach")
        for robot in settings.within_reach.robots
        for scene in settings.within_reach.scenes
    ]
    across = 2 if len(panels) == 4 else min(3, len(panels))
    down = -(-len(panels) // across)
    figure, grid = plt.subplots(down, across, figsize=(5.4 * across, 3.9 * down), squeeze=False)
    for axes in grid.flat[len(panels) :]:
        axes.set_axis_off()
    for axes, (name, scene, start) in zip(grid.flat, panels, strict=False):
        rows = table[
            (table["robot"] == name) & (table["apartment"] == scene) & (table["start"] == start)
        ]
        bars(axes, rows, load_robot(settings.robots[name].description))
        where = (
            "started anywhere"
            if start == "anywhere"
            else f"started with something within {100 * settings.reach:g} cm of the arm"
        )
        axes.set_title(
            f"{name} in {scene}, {where}\nn = {rows['n'].iloc[0]} for each degree of freedom",
            fontsize=8.5,
        )
    colours = {
        group: colour
        for robot in settings.robots.values()
        for group, colour in group_colours(load_robot(robot.description)).items()
    }
    handles = [
        plt.Rectangle((0, 0), 1, 1, color=colour, label=group) for group, colour in colours.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8)
    view = settings.fields_of_view[0]
    figure.suptitle(
        f"Threshold {settings.reference.threshold:g}, field of view {view:g} degrees; 95 % Wilson intervals",
        fontsize=9.5,
    )
    return figure
