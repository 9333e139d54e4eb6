"""Columns of tables: name, type, unit and description."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import pyarrow as pa

TEXT, INT, FLOAT, BOOL = pa.string(), pa.int64(), pa.float64(), pa.bool_()


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    name : str
    type : pyarrow.DataType
        One of TEXT, INT, FLOAT, BOOL.
    unit : str
        Empty for text, ``1`` for pure numbers.
    description : str
        What a value means; one line.
    key : bool
        Whether the column is part of the key, which no two rows share.
    nullable : bool
        Whether values may be missing, where no single number is defined.
    low, high : float, optional
        Range of the values, both ends included; a table with others is refused. Whole numbers are
        counts, lengths and seeds, and none of them is negative.
    added : bool
        Whether earlier versions wrote the table without it: if tables without a hash are read at
        all, its values are then missing.
    """

    name: str
    type: pa.DataType
    unit: str
    description: str
    key: bool = False
    nullable: bool = False
    low: float | None = None
    high: float | None = None
    added: bool = False

    @property
    def lowest(self) -> float | None:
        """The smallest value that is allowed; None if all are."""
        return 0 if self.low is None and self.type == INT else self.low


INTERVAL = (
    Column("ci_low", FLOAT, "1", "lower end of the 95 % interval", nullable=True),
    Column("ci_high", FLOAT, "1", "upper end of the 95 % interval", nullable=True),
)
P_VALUES = (
    Column("p", FLOAT, "1", "two-sided p-value", low=0, high=1),
    Column("p_adjusted", FLOAT, "1", "p-value after Holm's correction", low=0, high=1),
)


def arrow_schema(columns: Iterable[Column]) -> pa.Schema:
    """The Arrow schema of `columns`, with unit and description in each field's metadata."""
    return pa.schema(
        [
            pa.field(
                column.name,
                column.type,
                nullable=column.nullable,
                metadata={"unit": column.unit, "description": column.description},
            )
            for column in columns
        ]
    )
