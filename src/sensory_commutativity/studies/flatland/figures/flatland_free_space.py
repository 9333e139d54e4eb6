"""SCP where nothing can be touched but walls and joint stops, which should be about 1 (paper,
appendix B)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import (
    BLACK,
    BLUE,
    DOF_ORDER,
    GREEN,
    GREY,
    PURPLE,
    VERMILION,
    dof_label,
    error_lengths,
)

_STYLES = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"), (PURPLE, "D"), (BLACK, "v"))


def _cases(config: Config) -> list[tuple[str, str, str]]:
    """(world, agent, kind of room) of everything that is drawn."""
    flatland = config.flatland
    free, combinations = flatland.free_space, flatland.combinations
    cases = [(world, agent, "unbounded") for world in free.worlds for agent in free.agents]
    for world in combinations.worlds:
        if flatland.worlds[world].objects == 0 and flatland.worlds[world].walls:
            cases += [(world, agent, "closed, empty") for agent in combinations.agents]
    return cases


@figure(
    title="SCP in free space and in the closed empty room",
    inputs=["flatland_scp"],
    settings=lambda config: config.flatland,
)
def flatland_free_space(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A point per degree of freedom, agent and room."""
    cases = _cases(config)
    scp = tables["flatland_scp"]
    scp = scp[scp["threshold"] == 0].set_index(["world", "agent", "dof"]).sort_index()
    figure, axes = plt.subplots(figsize=(8.5, 4.2))
    for k, (world, agent, kind) in enumerate(cases):
        rows = scp.loc[(world, agent)].loc[DOF_ORDER]
        colour, marker = _STYLES[k % len(_STYLES)]
        axes.errorbar(
            [i + (k - (len(cases) - 1) / 2) * 0.17 for i in range(len(DOF_ORDER))],
            rows["scp"],
            yerr=error_lengths(rows["scp"], rows["ci_low"], rows["ci_high"]),
            fmt=marker,
            color=colour,
            markersize=5,
            elinewidth=1.2,
            capsize=2,
            label=f"{kind}: {agent} ({rows['n'].iloc[0]:,} each)",
        )
    axes.axhline(1, color=GREY, linewidth=0.8, linestyle=":")
    axes.set_xticks(range(len(DOF_ORDER)), [dof_label(dof, lines=True) for dof in DOF_ORDER])
    lowest = min(scp.loc[(world, agent)]["ci_low"].min() for world, agent, _ in cases)
    axes.set_ylim(max(0.0, lowest - 0.05), 1.02)
    axes.set_ylabel("SCP at threshold 0")
    axes.set_title("SCP where there is nothing to touch but joint stops and walls")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncol=2)
    return figure
