"""Columns that several tables of the atlas share."""

from __future__ import annotations

from ...storage.columns import TEXT, Column

ENVIRONMENT = Column("environment", TEXT, "", "key of atlas.environments", key=True)
ID = Column("id", TEXT, "", "name in Gymnasium's registry")
ACTION = Column("action", TEXT, "", "name of the action", key=True)
DOF = Column("dof", TEXT, "", "degree of freedom", key=True)
ACTION_SPACE = Column("action_space", TEXT, "", "how the action space was made", key=True)
