"""How the tables of two runs differ: not at all, by rounding, within their intervals, or beyond them.

Rows are matched by the shortest run of leading columns that tells all rows of both tables apart: tables begin with what was measured, followed by
what came out. A value is beyond its interval when the intervals of both runs do not meet; for two independent runs of the same thing that happens to
some 6 of 1,000 values by chance.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from ..errors import UserError
from ..storage.tables import TABLES, read_table

ROUNDING = 1e-9
"""Relative difference up to which two numbers are the same: another processor adds up in another order."""


class TableDifference(NamedTuple):
    """How a table differs between two runs.

    Attributes
    ----------
    table : str
    verdict : str
        ``identical``, ``rounding``, ``within``, ``beyond``, ``differs`` (it has no intervals), ``rows`` (they measured different things),
        ``only in A``, ``only in B``, or ``unreadable``.
    rows : int
        Rows that both have.
    differing : int
        Of these, those that differ.
    intervals, beyond : int
        Values with an interval that both have, and those of which the intervals do not meet.
    most : str
        The greatest difference in words; empty if there is none.
    """

    table: str
    verdict: str
    rows: int = 0
    differing: int = 0
    intervals: int = 0
    beyond: int = 0
    most: str = ""

    @property
    def by_chance(self) -> bool:
        """Whether two independent runs of the same thing may differ so; tables without intervals are given the benefit of the doubt."""
        return self.verdict in ("identical", "rounding", "within", "differs")


def compare_runs(a: Path, b: Path) -> list[TableDifference]:
    """Compare all tables of two folders of results, in the order of TABLES. Raises UserError where a folder holds none."""
    folders = [tables_of(run) for run in (a, b)]
    found = []
    for name in TABLES:
        there = [(folder / f"{name}.parquet").is_file() for folder in folders]
        if all(there):
            found.append(_compared(name, *(folder / f"{name}.parquet" for folder in folders)))
        elif any(there):
            found.append(TableDifference(name, f"only in {'A' if there[0] else 'B'}"))
    return found


def tables_of(run: Path) -> Path:
    """The folder of a run's tables. Raises UserError where there is none."""
    for folder in (run / "tables", run):
        if any(folder.glob("*.parquet")):
            return folder
    raise UserError(f"{run}: no run, it holds no tables; give a folder like results/default")


def _compared(name: str, a: Path, b: Path) -> TableDifference:
    try:
        return compare_tables(name, read_table(name, a), read_table(name, b))
    except UserError as error:
        return TableDifference(name, "unreadable", most=str(error))


def compare_tables(name: str, a: pd.DataFrame, b: pd.DataFrame) -> TableDifference:
    """Compare two tables of one name."""
    if a.equals(b):
        return TableDifference(name, "identical", len(a))
    key = key_of(a, b)
    if key is None:
        return TableDifference(name, "rows", most="their rows cannot be matched")
    one, other = (frame.set_index(key) for frame in (a, b))
    both = one.index.intersection(other.index, sort=False)
    left, right = one.loc[both], other.loc[both]
    differs = {column: _unlike(left[column], right[column]) for column in left.columns}
    differing = np.any(list(differs.values()), axis=0) if differs else np.zeros(len(both), bool)
    n, beyond = 0, 0
    for low, high in intervals(left):
        apart = (left[low] > right[high]) | (right[low] > left[high])
        n, beyond = (
            n + int((left[low].notna() & right[low].notna()).sum()),
            beyond + int(apart.sum()),
        )
    most = _most(left, right, differs)
    if len(both) < max(len(a), len(b)):
        verdict, most = (
            "rows",
            f"{len(a) - len(both)} rows only in A, {len(b) - len(both)} only in B{'; ' if most else ''}{most}",
        )
    elif not differing.any():
        verdict = "rounding"
    else:
        verdict = "beyond" if beyond else "within" if n else "differs"
    return TableDifference(name, verdict, len(both), int(differing.sum()), n, beyond, most)


def key_of(a: pd.DataFrame, b: pd.DataFrame) -> list[str] | None:
    """The shortest run of leading columns that tells all rows apart in both tables."""
    for k in range(1, len(a.columns) + 1):
        key = list(a.columns[:k])
        if not a.duplicated(key).any() and not b.duplicated(key).any():
            return key
    return None


def intervals(frame: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Names of the columns that hold the ends of an interval."""
    for low in frame.columns:
        high = low[: -len("low")] + "high"
        if low.endswith("_low") and high in frame.columns:
            yield low, high


def _unlike(a: pd.Series, b: pd.Series) -> np.ndarray:
    """Where two columns differ by more than rounding: bool (n,)."""
    if pd.api.types.is_float_dtype(a.dtype):
        return ~np.isclose(
            a.to_numpy(float), b.to_numpy(float), rtol=ROUNDING, atol=ROUNDING, equal_nan=True
        )
    return ~((a == b) | (a.isna() & b.isna())).to_numpy(bool)


def _most(a: pd.DataFrame, b: pd.DataFrame, differs: dict[str, np.ndarray]) -> str:
    """The greatest relative difference, in words: of results where they differ, else of counts, ends of intervals, or words."""
    unlike = {column: where for column, where in differs.items() if where.any()}
    results = {
        c: where
        for c, where in unlike.items()
        if pd.api.types.is_float_dtype(a[c].dtype) and not c.endswith(("_low", "_high"))
    }
    most, said = -1.0, ""
    for column, where in (results or unlike).items():
        if pd.api.types.is_bool_dtype(a[column].dtype) or not pd.api.types.is_numeric_dtype(
            a[column].dtype
        ):
            size, row = 0.0, int(np.argmax(where))
        else:
            x, y = a[column].to_numpy(float), b[column].to_numpy(float)
            with np.errstate(invalid="ignore", divide="ignore"):
                sizes = np.where(
                    where, np.abs(x - y) / np.maximum(np.maximum(np.abs(x), np.abs(y)), 1e-300), -1
                )
            row = int(np.argmax(np.where(np.isnan(sizes), np.inf, sizes)))
            size = float(sizes[row])
        if not size <= most:
            most, said = (
                size,
                f"{column} {_text(a[column].iloc[row])} and {_text(b[column].iloc[row])} at {_place(a.index[row])}",
            )
    return said


def _text(value) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _place(index) -> str:
    return ", ".join(_text(part) for part in (index if isinstance(index, tuple) else (index,)))
