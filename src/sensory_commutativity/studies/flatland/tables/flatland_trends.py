"""Does the SCP fall with the number of objects and with the length of the arms? (paper, appendix B)

The experiments of different worlds and agents are independent: each has start situations of its own.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ....statistics.paired import holm
from ....statistics.trends import cochran_armitage, mantel_haenszel
from ....storage.tables import read_table, write_table
from ...config import Config

OBJECTS, ARM_LENGTH = "more objects", "longer arms"


def find_trends(scp: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Cochran-Armitage over the number of objects for each agent; Cochran-Mantel-Haenszel over agents within worlds; all Holm-corrected together.

    `scp` is a flatland_scp table; rows of the combinations at threshold 0 are used. Arms are compared between the agents of the combinations with
    the shortest and the longest arms; where there is only one agent that comparison is left out.
    """
    flatland = config.flatland
    worlds, agents = flatland.combinations.worlds, flatland.combinations.agents
    counts = scp[
        (scp["threshold"] == 0) & scp["world"].isin(worlds) & scp["agent"].isin(agents)
    ].set_index(["agent", "dof", "world"])
    dofs = list(dict.fromkeys(counts.index.get_level_values("dof")))
    counts = counts.sort_index()
    objects = np.array([flatland.worlds[world].objects for world in worlds])
    shortest = min(agents, key=lambda agent: flatland.agents[agent].arm_length)
    longest = max(agents, key=lambda agent: flatland.agents[agent].arm_length)
    rows = []
    for dof in dofs:
        group = {agent: counts.loc[(agent, dof)].loc[worlds] for agent in agents}
        for agent in agents:
            test = cochran_armitage(group[agent]["commuted"], group[agent]["n"], objects)
            rows.append((OBJECTS, agent, dof, "Cochran-Armitage", test.z, test.slope, test.p))
        if shortest != longest:
            long, short = group[longest], group[shortest]
            test = mantel_haenszel(long["commuted"], long["n"], short["commuted"], short["n"])
            effect = float((long["scp"] - short["scp"]).mean())
            rows.append(
                (
                    ARM_LENGTH,
                    "all worlds",
                    dof,
                    "Cochran-Mantel-Haenszel",
                    test.odds_ratio,
                    effect,
                    test.p,
                )
            )
    table = pd.DataFrame(
        rows, columns=["trend", "stratum", "dof", "test", "statistic", "effect", "p"]
    )
    table["p_adjusted"] = holm(table["p"].to_numpy())
    return table.sort_values(["trend", "stratum"], ascending=[False, True], kind="stable")


def write_trends(scp: Path, out: Path, config: Config) -> None:
    write_table(
        "flatland_trends", find_trends(read_table("flatland_scp", scp), config), out, config
    )
