"""Columns that several tables of the navigation study share."""

from __future__ import annotations

from ...storage.columns import INT, TEXT, Column

ACTION_SPACE = Column(
    "action_space",
    TEXT,
    "",
    "full, truncated, adapted, or a control: base-random, random-half, inverse",
    key=True,
)
RUN = (ACTION_SPACE, Column("seed", INT, "1", "number of the training run", key=True))
PAIR = (
    Column(
        "family", TEXT, "",
        "paper: pairs of the three action spaces that the paper compares; controls: other pairs",
        key=True,
    ),
    Column("a", TEXT, "", "action space", key=True),
    Column("b", TEXT, "", "action space that a is compared with", key=True),
)  # fmt: skip
MEASURE = Column("measure", TEXT, "", "score, a column of navigation_scores", key=True)
