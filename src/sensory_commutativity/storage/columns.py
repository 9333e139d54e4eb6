"""What all tables share: how a column is described, and columns that several tables have."""

from __future__ import annotations

from typing import NamedTuple

import pyarrow as pa

NULLABLE = (
    "ci_low", "ci_high", "excess_error", "spearman", "kendall", "statistic", "df", "difference", "effect_size",
    "tau", "median", "median_low", "median_high", "iqm", "iqm_low", "iqm_high", "loss",
    "iou", "iou_1", "iou_2", "mean_iou", "iou_ci_low", "iou_ci_high", "median_iou", "pooled_iou", "accuracy", "p_tuples",
    "recall_identical", "recall_different", "recall_moved", "hits", "hits_low", "hits_high", "false_hits", "false_hits_low", "false_hits_high",
    "estimate", "hits_difference", "hits_p",
)  # fmt: skip
"""Columns that may be empty: where there is no single number, or it is not defined."""


class Column(NamedTuple):
    name: str
    type: pa.DataType
    unit: str
    description: str


Tables = dict[str, tuple[Column, ...]]
"""Name of a table -> its columns."""

TEXT, INT, FLOAT, BOOL = pa.string(), pa.int64(), pa.float64(), pa.bool_()
INTERVAL = (
    Column("ci_low", FLOAT, "1", "lower end of the 95 % interval"),
    Column("ci_high", FLOAT, "1", "upper end of the 95 % interval"),
)
TEST = (
    Column("p", FLOAT, "1", "two-sided p-value"),
    Column("p_adjusted", FLOAT, "1", "p-value after Holm's correction"),
)
WHERE = (
    Column("world", TEXT, "", "kind of room, a key of flatland.worlds"),
    Column("agent", TEXT, "", "a key of flatland.agents"),
)
SCP = (
    *WHERE,
    Column("length", INT, "actions", "length of the sequences"),
    Column("dof", TEXT, "", "degree of freedom"),
    Column("threshold", FLOAT, "squared 8-bit colour", "largest distance that counts as equal"),
    Column("n", INT, "1", "SC-experiments"),
    Column("commuted", INT, "1", "how many of them commuted"),
    Column("scp", FLOAT, "1", "sensory commutativity probability"),
    *INTERVAL,
)
