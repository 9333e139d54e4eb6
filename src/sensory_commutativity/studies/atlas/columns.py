"""Columns that several tables of the atlas share."""

from __future__ import annotations

from ...storage.columns import TEXT, Column

ENVIRONMENT = Column("environment", TEXT, "", "key of atlas.environments", key=True)
ID = Column("id", TEXT, "", "name in Gymnasium's registry")
ACTION = Column("action", TEXT, "", "name of the action", key=True)
