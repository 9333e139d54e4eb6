"""Columns that several tables of the gallery share."""

from __future__ import annotations

from ...storage.columns import TEXT, Column

ROBOT = Column("robot", TEXT, "", "key of gallery.robots", key=True)
SCENE = Column("scene", TEXT, "", "key of gallery.scenes", key=True)
DOF = Column("dof", TEXT, "", "degree of freedom", key=True)
GROUP = Column("group", TEXT, "", "kind of joint")
