"""Columns that several tables of Flatland share."""

from __future__ import annotations

from ...storage.columns import FLOAT, INT, INTERVAL, TEXT, Column

WORLD = Column("world", TEXT, "", "kind of room, a key of flatland.worlds", key=True)
AGENT = Column("agent", TEXT, "", "a key of flatland.agents", key=True)
LENGTH = Column("length", INT, "actions", "length of the sequences", key=True)
DOF = Column("dof", TEXT, "", "degree of freedom", key=True)
DOF_A = Column("dof_a", TEXT, "", "degree of freedom", key=True)
DOF_B = Column("dof_b", TEXT, "", "degree of freedom", key=True)
SEED = Column("seed", INT, "1", "seed of the experiment")
DISTANCE = Column(
    "distance",
    FLOAT,
    "squared 8-bit colour",
    "mean squared error of the two final observations",
    low=0,
)
SCP = (
    WORLD,
    AGENT,
    LENGTH,
    DOF,
    Column(
        "threshold",
        FLOAT,
        "squared 8-bit colour",
        "largest distance that counts as equal",
        key=True,
        low=0,
    ),
    Column("n", INT, "1", "SC-experiments"),
    Column("commuted", INT, "1", "how many of them commuted"),
    Column("scp", FLOAT, "1", "sensory commutativity probability", low=0, high=1),
    *INTERVAL,
)
