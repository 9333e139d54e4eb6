"""SCP for combinations of agents and rooms: more objects, longer arms (paper, appendix B)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....seeding import generator, seed_for
from ....worlds.flatland.drawing import draw_room
from ...config import Config
from ...declarations import figure
from ...plotting import DOF_ORDER, dof_bars, dof_label, probability_axis
from ..builders import flatland_world
from ..hierarchy import ALPHA
from ..tables.flatland_trends import ARM_LENGTH, OBJECTS


def _example(axes: Axes, config: Config, world: str, agent: str) -> None:
    example = flatland_world(config.flatland, world, agent)
    example.reset(generator(seed_for(config.seed, "flatland", world, agent, 0), "situation"))
    draw_room(axes, example)


def _marked(dof: str, trends: pd.DataFrame, agent: str) -> str:
    """The label of a degree of freedom, with a mark for each trend that it shows."""
    marks = ((OBJECTS, agent, "*"), (ARM_LENGTH, "all worlds", "†"))
    found = [
        mark
        for trend, stratum, mark in marks
        if (trend, stratum, dof) in trends.index
        and trends.loc[(trend, stratum, dof), "p_adjusted"] < ALPHA
    ]
    return f"{dof_label(dof)} {''.join(found)}".strip()


@figure(
    title="SCP for combinations of agents and rooms: more objects, longer arms",
    inputs=["flatland_scp", "flatland_trends"],
    settings=lambda config: config.flatland,
)
def flatland_combinations(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    flatland = config.flatland
    worlds, agents = flatland.combinations.worlds, flatland.combinations.agents
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
        for j, world in enumerate(worlds):
            picture, bars = grid[2 * i, j], grid[2 * i + 1, j]
            _example(picture, config, world, agent)
            things = flatland.worlds[world].objects
            picture.set_title(
                f"{agent}: arms of 2 × {flatland.agents[agent].arm_length:g} units\n{things} objects",
                fontsize=9,
            )
            rows = scp.loc[(world, agent)].loc[DOF_ORDER]
            dof_bars(bars, DOF_ORDER, rows["scp"], rows["ci_low"], rows["ci_high"], digits=2)
            probability_axis(bars, "SCP" if j == 0 else "")
            bars.set_xticks(
                range(len(DOF_ORDER)), [_marked(dof, trends, agent) for dof in DOF_ORDER]
            )
    n = int(scp.loc[(worlds[0], agents[0])]["n"].iloc[0])
    figure.suptitle(
        f"SCP at threshold 0 in rooms with more objects (columns) and for longer arms (rows); {n:,} experiments per bar, 95 % intervals\n"
        f"*: changes with the number of objects in this row; †: changes with arm length (p < {ALPHA}, Holm-corrected)",
        fontsize=11,
    )
    return figure
