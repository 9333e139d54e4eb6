"""Columns that several tables of the apartment share."""

from __future__ import annotations

from ...storage.columns import FLOAT, INT, TEXT, Column

ROBOT = Column("robot", TEXT, "", "a key of apartment.robots", key=True)
CONDITION = (
    ROBOT,
    Column("apartment", TEXT, "", "a key of apartment.scenes", key=True),
    Column(
        "start",
        TEXT,
        "",
        "anywhere, or within-reach: something is within the arm's reach",
        key=True,
    ),
    Column("length", INT, "actions", "length of the sequences", key=True),
)
VIEW = Column(
    "field_of_view", FLOAT, "degrees", "vertical field of view of the camera", key=True, low=0
)
DOF = Column("dof", TEXT, "", "degree of freedom", key=True)
THRESHOLD = Column(
    "threshold",
    FLOAT,
    "squared VGG16 feature",
    "largest distance that counts as equal",
    key=True,
    low=0,
)
