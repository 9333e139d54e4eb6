"""SCP for combinations of agents and rooms: more objects, longer arms (paper, appendix B)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....seeding import generator, seed_for
from ...config import Config
from ...declarations import figure
from ...plotting import DOF_ORDER, dof_label, draw_dof_bars, set_probability_axis
from ..builders import flatland_world
from ..hierarchy import ALPHA
from ..tables.flatland_trends import ARM_LENGTH, OBJECTS


@figure(
    title="SCP in rooms with more objects and for agents with longer arms",
    inputs=["flatland_scp", "flatland_trends"],
    settings=lambda config: config.flatland,
)
def flatland_combinations(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A pair of panels per agent (row) and room (column): one start situation, and the SCPs."""
    worlds, agents = config.flatland.combinations.worlds, config.flatland.combinations.agents
    scp = tables["flatland_scp"]
    scp = scp[scp["threshold"] == 0].set_index(["world", "agent", "dof"]).sort_index()
    trends = tables["flatland_trends"].set_index(["trend", "stratum", "dof"])
    figure, grid = plt.subplots(
        2 * len(agents),
        len(worlds),
        figsize=(3.1 * len(worlds), 6.2 * len(agents)),
        height_ratios=[1.1, 1] * len(agents),
        squeeze=False,
    )
    for i, agent in enumerate(agents):
        labels = [_label_with_trends(dof, trends, agent) for dof in DOF_ORDER]
        for j, world in enumerate(worlds):
            room, bars = grid[2 * i, j], grid[2 * i + 1, j]
            _draw_example(room, config, world, agent)
            rows = scp.loc[(world, agent)].loc[DOF_ORDER]
            draw_dof_bars(bars, rows["scp"], rows["ci_low"], rows["ci_high"], digits=2)
            set_probability_axis(bars, "SCP" if j == 0 else "")
            bars.set_xticks(range(len(DOF_ORDER)), labels)
    n = int(scp.loc[(worlds[0], agents[0])]["n"].iloc[0])
    figure.suptitle(
        "SCP at threshold 0 in rooms with more objects (columns) and for longer arms (rows); "
        f"{n:,} experiments per bar, 95 % intervals\n"
        "*: changes with the number of objects in this row; †: changes with arm length "
        f"(p < {ALPHA}, Holm-corrected)",
        fontsize=11,
    )
    return figure


def _draw_example(axes: Axes, config: Config, world: str, agent: str) -> None:
    """Draw the start situation of the first experiment."""
    from ....worlds.flatland.drawing import draw_room  # imports numba and pymunk

    flatland = config.flatland
    example = flatland_world(flatland, world, agent)
    example.reset(generator(seed_for(config.seed, "flatland", world, agent, 0), "situation"))
    draw_room(axes, example)
    axes.set_title(
        f"{agent}: arms of 2 × {flatland.agents[agent].arm_length:g} units\n"
        f"{flatland.worlds[world].objects} objects",
        fontsize=9,
    )


def _label_with_trends(dof: str, trends: pd.DataFrame, agent: str) -> str:
    """Label of a degree of freedom, with a mark for each significant trend of its SCP."""
    marks = ((OBJECTS, agent, "*"), (ARM_LENGTH, "all worlds", "†"))
    significant = [
        mark
        for trend, stratum, mark in marks
        if (trend, stratum, dof) in trends.index
        and trends.loc[(trend, stratum, dof), "p_adjusted"] < ALPHA
    ]
    return f"{dof_label(dof)} {''.join(significant)}".strip()
