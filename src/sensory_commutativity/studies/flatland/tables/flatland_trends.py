"""Whether the SCP falls with the number of objects and with the length of the arms (paper,
appendix B).

The experiments of different worlds and agents are independent: each has its own start situations.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....storage.columns import FLOAT, P_VALUES, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import DOFS
from ..columns import DOF

OBJECTS, ARM_LENGTH = "more objects", "longer arms"


def _expected(config: Config) -> Expected:
    flatland = config.flatland
    agents = flatland.combinations.agents
    rows = {(OBJECTS, dof): len(agents) for dof in DOFS}
    if len({flatland.agents[agent].arm_length for agent in agents}) > 1:
        rows |= {(ARM_LENGTH, dof): 1 for dof in DOFS}
    return Expected(("trend", "dof"), rows)


@table(
    title="Trends of the SCP with objects and arm length",
    columns=(
        Column("trend", TEXT, "", "objects or arm length", key=True),
        Column("stratum", TEXT, "", "the agent for objects; all worlds for arm length", key=True),
        DOF,
        Column("test", TEXT, "", "name of the test"),
        Column("statistic", FLOAT, "1", "z of the trend, or the pooled odds ratio", nullable=True),
        Column(
            "effect", FLOAT, "1", "change of SCP per object, or from the shorter to the longer arms"
        ),
        *P_VALUES,
    ),
    inputs=["flatland_scp"],
    settings=lambda config: [
        config.flatland.combinations,
        {world: config.flatland.worlds[world] for world in config.flatland.combinations.worlds},
        {agent: config.flatland.agents[agent] for agent in config.flatland.combinations.agents},
    ],
    expected=_expected,
)
def flatland_trends(scp: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Cochran-Armitage tests over the number of objects for each agent, and
    Cochran-Mantel-Haenszel tests over agents within worlds, all Holm-corrected together.

    Rows of the combinations at threshold 0 are used. Arms are compared between the agents with the
    shortest and the longest arms; with a single agent there is no such comparison.
    """
    from ....statistics.paired import holm
    from ....statistics.trends import cochran_armitage, mantel_haenszel

    flatland = config.flatland
    worlds, agents = flatland.combinations.worlds, flatland.combinations.agents
    chosen = (scp["threshold"] == 0) & scp["world"].isin(worlds) & scp["agent"].isin(agents)
    counts = scp[chosen].set_index(["agent", "dof", "world"])
    dofs = list(dict.fromkeys(counts.index.get_level_values("dof")))
    counts = counts.sort_index()
    objects = np.array([flatland.worlds[world].objects for world in worlds])
    shortest = min(agents, key=lambda agent: flatland.agents[agent].arm_length)
    longest = max(agents, key=lambda agent: flatland.agents[agent].arm_length)
    rows = []
    for dof in dofs:
        group = {agent: counts.loc[(agent, dof)].loc[worlds] for agent in agents}
        for agent in agents:
            trend = cochran_armitage(group[agent]["commuted"], group[agent]["n"], objects)
            rows.append((OBJECTS, agent, dof, "Cochran-Armitage", trend.z, trend.slope, trend.p))
        if shortest != longest:
            long, short = group[longest], group[shortest]
            pooled = mantel_haenszel(long["commuted"], long["n"], short["commuted"], short["n"])
            effect = float((long["scp"] - short["scp"]).mean())
            rows.append((ARM_LENGTH, "all worlds", dof, "Cochran-Mantel-Haenszel",
                         pooled.odds_ratio, effect, pooled.p))  # fmt: skip
    columns = ["trend", "stratum", "dof", "test", "statistic", "effect", "p"]
    trends = pd.DataFrame(rows, columns=columns)
    trends["p_adjusted"] = holm(trends["p"].to_numpy())
    return trends.sort_values(["trend", "stratum"], ascending=[False, True], kind="stable")
