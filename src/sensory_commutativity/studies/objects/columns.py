"""Columns that several tables of the objects study share."""

from __future__ import annotations

from ...storage.columns import INT, TEXT, Column

MODEL = Column(
    "model", TEXT, "", "raft, flownet, or difference: image difference, nothing learned", key=True
)
TEST_SET = Column(
    "test_set", TEXT, "",
    "as-trained, or what is new: other-view, other-objects, other-apartments, all-other", key=True,
)  # fmt: skip
HOUSEHOLD = Column(
    "household", INT, "1",
    "number of the cluttered scene: its SC-experiments share objects and layouts", key=True,
)  # fmt: skip
KIND = Column(
    "kind", TEXT, "",
    "of the sequences: random, or left-right, after which the first order ends where it began",
    key=True,
)  # fmt: skip
COMPARISONS = ("sc-experiment", "first-last", "return")
"""What is compared; as in :mod:`....change_detection.simulated.object_experiments`."""
COMPARISON = Column(
    "comparison", TEXT, "",
    "sc-experiment: both orders; first-last: start and end; return: start, and back there",
    key=True,
)  # fmt: skip
OUTCOME_TRUE = Column(
    "outcome_true", TEXT, "", "identical, different or moved, according to the simulator"
)
