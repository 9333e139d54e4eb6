"""Comparison of the tables of two runs: identical, equal up to rounding, within their intervals?

Rows are matched by the table's key. A value is beyond its interval if the intervals of the two
runs are disjoint. Between two independent runs of the same experiments that happens by chance to
some 6 of 1,000 values with 95 % intervals.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ..errors import UserError
from ..storage.tables import read_table

ROUNDING = 1e-9
"""Relative difference up to which two numbers are equal; chosen: processors sum in other orders,
and no result depends on its ninth digit."""


class TableDifference(NamedTuple):
    """How a table differs between two runs, A and B.

    Attributes
    ----------
    table : str
    status : str
        ``identical``, ``rounding``, ``within``, ``beyond``, ``differs`` (there are no intervals),
        ``rows`` (other rows), ``only in A``, ``only in B``, or ``unreadable``.
    rows : int
        Rows that both have.
    differing_rows : int
        How many of these differ.
    intervals, disjoint_intervals : int
        Values with an interval in both, and how many of these intervals are disjoint.
    largest_difference : str
        The largest difference in words, or why the table is unreadable; may be empty.
    """

    table: str
    status: str
    rows: int = 0
    differing_rows: int = 0
    intervals: int = 0
    disjoint_intervals: int = 0
    largest_difference: str = ""

    @property
    def is_by_chance(self) -> bool:
        """Whether independent runs can differ like this; assumed for tables without intervals."""
        return self.status in ("identical", "rounding", "within", "differs")


def compare_runs(a: Path, b: Path) -> list[TableDifference]:
    """Compare all tables of two folders of results.

    Raises
    ------
    UserError
        If a folder holds no tables.
    """
    from ..studies.registry import table_names

    folders = [find_tables_folder(run) for run in (a, b)]
    differences = []
    for name in table_names():
        paths = [folder / f"{name}.parquet" for folder in folders]
        exists = [path.is_file() for path in paths]
        if all(exists):
            differences.append(_compare_files(name, *paths))
        elif any(exists):
            differences.append(TableDifference(name, f"only in {'A' if exists[0] else 'B'}"))
    return differences


def find_tables_folder(run: Path) -> Path:
    """Find the folder of a run's tables: ``RUN/tables`` or RUN itself. Raises UserError."""
    for folder in (run / "tables", run):
        if any(folder.glob("*.parquet")):
            return folder
    raise UserError(f"{run}: not a run, it holds no tables; give a folder like results/default")


def _compare_files(name: str, a: Path, b: Path) -> TableDifference:
    from ..studies.registry import find_table

    columns = find_table(name).columns
    try:
        table_a, table_b = (read_table(path, name, columns, require_hash=False) for path in (a, b))
    except UserError as error:
        return TableDifference(name, "unreadable", largest_difference=str(error))
    return compare_tables(name, table_a, table_b, [c.name for c in columns if c.key])


def compare_tables(
    name: str, a: pd.DataFrame, b: pd.DataFrame, key: Sequence[str] = ()
) -> TableDifference:
    """Compare two tables of the same columns.

    Parameters
    ----------
    name : str
    a, b : DataFrame
    key : sequence of str
        Columns that identify a row. By default the shortest sequence of leading columns that
        identifies the rows of both.
    """
    if a.equals(b):
        return TableDifference(name, "identical", len(a))
    key = list(key) or _guess_key(a, b)
    if not key:
        return TableDifference(name, "rows", largest_difference="the rows cannot be matched")
    indexed_a, indexed_b = a.set_index(key), b.set_index(key)
    shared = indexed_a.index.intersection(indexed_b.index, sort=False)
    left, right = indexed_a.loc[shared], indexed_b.loc[shared]
    differs = {column: _find_differences(left[column], right[column]) for column in left.columns}
    rows_differ = np.any(list(differs.values()), axis=0) if differs else np.zeros(len(shared), bool)
    intervals = disjoint = 0
    for low, high in _interval_columns(left):
        intervals += int((left[low].notna() & right[low].notna()).sum())
        disjoint += int(((left[low] > right[high]) | (right[low] > left[high])).sum())
    largest = _describe_largest(left, right, differs)
    if len(shared) < max(len(a), len(b)):
        status = "rows"
        only_a, only_b = len(a) - len(shared), len(b) - len(shared)
        separator = "; " if largest else ""
        largest = f"{only_a} rows only in A, {only_b} only in B{separator}{largest}"
    elif not rows_differ.any():
        status = "rounding"
    elif disjoint:
        status = "beyond"
    else:
        status = "within" if intervals else "differs"
    return TableDifference(
        name, status, len(shared), int(rows_differ.sum()), intervals, disjoint, largest
    )


def _guess_key(a: pd.DataFrame, b: pd.DataFrame) -> list[str]:
    """The shortest sequence of leading columns without repetitions in either table, or []."""
    for k in range(1, len(a.columns) + 1):
        key = list(a.columns[:k])
        if not a.duplicated(key).any() and not b.duplicated(key).any():
            return key
    return []


def _interval_columns(frame: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Names of the columns of the lower and upper ends of intervals."""
    for low in frame.columns:
        high = low[: -len("low")] + "high"
        if low.endswith("_low") and high in frame.columns:
            yield low, high


def _find_differences(a: pd.Series, b: pd.Series) -> np.ndarray:
    """Where two columns differ by more than rounding: bool (n,)."""
    if pd.api.types.is_float_dtype(a.dtype):
        x, y = a.to_numpy(float), b.to_numpy(float)
        return ~np.isclose(x, y, rtol=ROUNDING, atol=ROUNDING, equal_nan=True)
    return ~((a == b) | (a.isna() & b.isna())).to_numpy(bool)


def _describe_largest(a: pd.DataFrame, b: pd.DataFrame, differs: dict[str, np.ndarray]) -> str:
    """Describe the largest relative difference, or return "" if there is none.

    Among estimates if some differ, else among counts, ends of intervals, and text.
    """
    differing = {column: rows for column, rows in differs.items() if rows.any()}
    estimates = {
        column: rows
        for column, rows in differing.items()
        if pd.api.types.is_float_dtype(a[column].dtype) and not column.endswith(("_low", "_high"))
    }
    largest, description = -1.0, ""
    for column, rows in (estimates or differing).items():
        row, size = _find_largest(a[column], b[column], rows)
        if not size <= largest:
            largest = size
            values = f"{_format(a[column].iloc[row])} and {_format(b[column].iloc[row])}"
            description = f"{column} {values} at {_format_index(a.index[row])}"
    return description


def _find_largest(a: pd.Series, b: pd.Series, rows: np.ndarray) -> tuple[int, float]:
    """Row and size of the largest relative difference among `rows`; size 0 if not numeric."""
    if pd.api.types.is_bool_dtype(a.dtype) or not pd.api.types.is_numeric_dtype(a.dtype):
        return int(np.argmax(rows)), 0.0
    x, y = a.to_numpy(float), b.to_numpy(float)
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.maximum(np.maximum(np.abs(x), np.abs(y)), 1e-300)
        sizes = np.where(rows, np.abs(x - y) / scale, -1)
    row = int(np.argmax(np.where(np.isnan(sizes), np.inf, sizes)))
    return row, float(sizes[row])


def _format(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _format_index(index: Any) -> str:
    return ", ".join(_format(part) for part in (index if isinstance(index, tuple) else (index,)))
