"""The simulation: Polyphemus in its room, from above and through its eye (paper, Fig. "Simulation
used for our experiments")."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ....seeding import generator, seed_for
from ...config import Config
from ...declarations import figure
from ...plotting import dof_label
from .. import builders

if TYPE_CHECKING:
    from ....worlds.flatland.world import FlatlandWorld


@figure(
    title="The agent of Flatland in its room, from above and through its eye",
    settings=lambda config: config.flatland,
)
def flatland_world(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """The start situation of the first experiment, the view, and the degrees of freedom."""
    from ....worlds.flatland.drawing import draw_room, draw_view  # imports numba and pymunk

    reference = config.flatland.reference
    world = builders.flatland_world(config.flatland, reference.world, reference.agent)
    seed = seed_for(config.seed, "flatland", reference.world, reference.agent, 0)
    world.reset(generator(seed, "situation"))
    figure = plt.figure(figsize=(7.6, 7.2))
    grid = figure.add_gridspec(2, 2, height_ratios=[12, 1], width_ratios=[1.45, 1])
    room = figure.add_subplot(grid[0, 0])
    view = figure.add_subplot(grid[1, :])
    notes = figure.add_subplot(grid[0, 1])
    draw_room(room, world)
    room.set_title(f"Polyphemus in a room of {world.room.width:g} × {world.room.height:g} units")
    draw_view(view, world.observe())
    degrees = math.degrees(world.agent.field_of_view)
    view.set_title(
        f"what its eye sees: {world.agent.pixels} RGB pixels over {degrees:g}°; its own arms, too, "
        "when they are in sight",
        fontsize=9,
    )
    _draw_notes(notes, world)
    return figure


def _draw_notes(axes: Axes, world: FlatlandWorld) -> None:
    """Write the speeds of the degrees of freedom, and the legend of the room."""
    axes.set_axis_off()
    lines = ["eight degrees of freedom;", "an action of 1 moves, per step:", ""]
    for dof in world.dofs:
        speed = np.format_float_positional(dof.speed, trim="-")
        lines.append(f"{dof_label(dof.name):18s} {speed} {'' if dof.unit == '1' else dof.unit}")
    axes.text(
        0, 0.98, "\n".join(lines), va="top", family="DejaVu Sans Mono", fontsize=7.5,
        transform=axes.transAxes,
    )  # fmt: skip
    disc: dict[str, Any] = dict(marker="o", markersize=12, linestyle="")
    disc |= dict(markerfacecolor="#dddddd", markeredgecolor="black")
    path: dict[str, Any] = dict(color="black", linestyle=":", linewidth=1.4)
    sight: dict[str, Any] = dict(marker="s", markersize=12, alpha=0.5, linestyle="")
    handles = [
        Line2D([], [], markeredgewidth=2.4, label="fixed", **disc),
        Line2D([], [], markeredgewidth=0.8, label="movable", **disc),
        Line2D([], [], label="moving (dotted outline), along the dotted path", **path),
        Line2D([], [], label="field of view", color="#ffd94d", **sight),
    ]
    axes.legend(handles=handles, loc="lower left", labelspacing=1.4, fontsize=8)
