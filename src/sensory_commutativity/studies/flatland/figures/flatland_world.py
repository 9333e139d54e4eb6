"""The simulation: Polyphemus in its room, from above and through its eye (paper, Fig. "Simulation used for our experiments")."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ....seeding import generator, seed_for
from ....worlds.flatland.drawing import draw_room, draw_view
from ...config import Config
from ...declarations import figure
from ...plotting import dof_label
from ..builders import flatland_world


@figure(
    title="The simulation: Polyphemus in its room, from above and through its eye",
    settings=lambda config: config.flatland,
)
def flatland_world(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    reference = config.flatland.reference
    world = flatland_world(config.flatland, reference.world, reference.agent)
    world.reset(
        generator(
            seed_for(config.seed, "flatland", reference.world, reference.agent, 0), "situation"
        )
    )
    figure = plt.figure(figsize=(7.6, 7.2))
    grid = figure.add_gridspec(2, 2, height_ratios=[12, 1], width_ratios=[1.45, 1])
    room, view, notes = (
        figure.add_subplot(grid[0, 0]),
        figure.add_subplot(grid[1, :]),
        figure.add_subplot(grid[0, 1]),
    )
    draw_room(room, world)
    room.set_title(f"Polyphemus in a room of {world.room.width:g} × {world.room.height:g} units")
    draw_view(view, world.observe())
    degrees = math.degrees(world.agent.field_of_view)
    view.set_title(
        f"what its eye sees: {world.agent.pixels} RGB pixels over {degrees:g}°; its own arms, too, when they are in sight",
        fontsize=9,
    )

    notes.set_axis_off()
    lines = ["eight degrees of freedom;", "an action of 1 moves, per step:", ""]
    for dof in world.dofs:
        lines.append(
            f"{dof_label(dof.name):18s} {np.format_float_positional(dof.speed, trim='-')} {'' if dof.unit == '1' else dof.unit}"
        )
    notes.text(
        0,
        0.98,
        "\n".join(lines),
        va="top",
        family="DejaVu Sans Mono",
        fontsize=7.5,
        transform=notes.transAxes,
    )
    dot = dict(
        marker="o", markersize=12, markerfacecolor="#dddddd", markeredgecolor="black", linestyle=""
    )
    handles = [
        Line2D([], [], markeredgewidth=width, label=name, **dot)
        for name, width in (("fixed", 2.4), ("movable", 0.8))
    ]
    handles.append(
        Line2D(
            [],
            [],
            color="black",
            linestyle=":",
            linewidth=1.4,
            label="moving (dotted outline), along the dotted path",
        )
    )
    handles.append(
        Line2D(
            [],
            [],
            marker="s",
            markersize=12,
            color="#ffd94d",
            alpha=0.5,
            linestyle="",
            label="field of view",
        )
    )
    notes.legend(handles=handles, loc="lower left", labelspacing=1.4, fontsize=8)
    return figure
