"""Where nothing is in the way everything should commute: free space and the closed empty room (theory; paper, appendix B)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLACK, BLUE, DOF_ORDER, GREEN, GREY, PURPLE, VERMILION, dof_label

_MARKS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"), (PURPLE, "D"), (BLACK, "v"))


@figure(
    title="Where nothing is in the way everything should commute: free space and the closed empty room (theory; paper, appendix B)",
    inputs=["flatland_scp"],
    settings=lambda config: config.flatland,
)
def flatland_free_space(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    flatland = config.flatland
    empty = [
        world
        for world in flatland.combinations.worlds
        if flatland.worlds[world].objects == 0 and flatland.worlds[world].walls
    ]
    cases = [
        (w, a, "unbounded") for w in flatland.free_space.worlds for a in flatland.free_space.agents
    ]
    cases += [(w, a, "closed, empty") for w in empty for a in flatland.combinations.agents]
    scp = tables["flatland_scp"]
    scp = scp[scp["threshold"] == 0].set_index(["world", "agent", "dof"]).sort_index()
    figure, axes = plt.subplots(figsize=(8.5, 4.2))
    for k, (world, agent, kind) in enumerate(cases):
        rows = scp.loc[(world, agent)].loc[DOF_ORDER]
        colour, marker = _MARKS[k % len(_MARKS)]
        x = [i + (k - (len(cases) - 1) / 2) * 0.17 for i in range(len(DOF_ORDER))]
        error = [
            (rows["scp"] - rows["ci_low"]).clip(lower=0),
            (rows["ci_high"] - rows["scp"]).clip(lower=0),
        ]
        name = f"{kind}: {agent} ({rows['n'].iloc[0]:,} each)"
        axes.errorbar(
            x,
            rows["scp"],
            yerr=error,
            fmt=marker,
            color=colour,
            markersize=5,
            elinewidth=1.2,
            capsize=2,
            label=name,
        )
    axes.axhline(1, color=GREY, linewidth=0.8, linestyle=":")
    axes.set_xticks(range(len(DOF_ORDER)), [dof_label(d, lines=True) for d in DOF_ORDER])
    lowest = min(scp.loc[(w, a)]["ci_low"].min() for w, a, _ in cases)
    axes.set_ylim(max(0.0, lowest - 0.05), 1.02)
    axes.set_ylabel("SCP at threshold 0")
    axes.set_title("SCP where there is nothing to touch but joint stops and walls")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncol=2)
    return figure
