"""Columns that several tables share."""

from __future__ import annotations

from ...storage.columns import FLOAT, INT, TEXT, Column

WORLD = Column("world", TEXT, "", "a key of reset_free.flatland or reset_free.apartment", key=True)
DOF = Column("dof", TEXT, "", "degree of freedom", key=True)
EXPERIMENT = Column("experiment", INT, "1", "number of the trial", key=True)
DISTANCES = (
    Column("reset", FLOAT, "1", "distance of the two orders, each from a restored start: truth"),
    Column("distance", FLOAT, "1", "distance of the two orders, with a return between them"),
    Column("control", FLOAT, "1", "distance of the second order and the same played again"),
    Column("returned", FLOAT, "1", "distance of the views of the start before and after a return"),
    Column("waited", FLOAT, "1", "distance of the views of the start before and after two returns"),
)
"""Squared 8-bit colour in Flatland, squared VGG16 feature in apartments."""
