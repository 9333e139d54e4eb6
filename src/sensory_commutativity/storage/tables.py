"""Tables in Parquet files: tidy, with units and provenance in the file's own metadata.

Two hashes are part of the metadata: ``rows_sha256`` of the values of all columns, and ``seal`` of
the whole file (:mod:`.seal`). Both are checked whenever a table is read.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import TableError
from .atomic import atomic_write
from .columns import Column, arrow_schema
from .files import check_regular_file, printable, read_bounded
from .parquet import TableTooLargeError, hash_rows, read_bounded_table
from .seal import SEAL, SEAL_KEY, is_intact, seal

ROWS_HASH = "rows_sha256"
"""Metadata key of the hash of the rows; that of the whole file is SEAL_KEY."""
MAX_BYTES = 300_000_000
"""Size of a file; chosen: hundreds of times that of our largest."""
REMEDY = "delete it and run again"
_MAGIC = b"PAR1"
UNHASHED = (
    "carries no content hash, so it was written before tables had one, or it is damaged; the "
    "workflow makes it again"
)


class StoredTable(NamedTuple):
    """The rows of a table, and its metadata without what pandas adds."""

    frame: pd.DataFrame
    metadata: dict[str, str]


def write_table(
    path: Path,
    name: str,
    columns: Sequence[Column],
    frame: pd.DataFrame,
    metadata: Mapping[str, str],
) -> None:
    """Write the columns of `frame` that the table declares, in the declared order.

    Parameters
    ----------
    path : Path
    name : str
        Name of the table, stored as the metadata key ``table``.
    columns : sequence of Column
    frame : DataFrame
        Has all of `columns`; further columns are not written.
    metadata : mapping of str to str
        Where the table comes from.
    """
    chosen = frame[[column.name for column in columns]]
    table = pa.Table.from_pandas(chosen, arrow_schema(columns), preserve_index=False)
    described = {"table": name, **metadata, ROWS_HASH: hash_rows(table), SEAL_KEY: SEAL}
    table = table.replace_schema_metadata(described)
    content = io.BytesIO()
    pq.write_table(table, content, compression="zstd", write_page_checksum=True)
    with atomic_write(path) as temporary:
        temporary.write_bytes(seal(content.getvalue()))


def read_table(
    path: Path,
    name: str,
    columns: Sequence[Column],
    remedy: str = REMEDY,
    require_hash: bool = True,
) -> pd.DataFrame:
    """Read the rows of a table; see :func:`read_stored_table`."""
    return read_stored_table(path, name, columns, remedy, require_hash).frame


def read_stored_table(
    path: Path,
    name: str,
    columns: Sequence[Column],
    remedy: str = REMEDY,
    require_hash: bool = True,
) -> StoredTable:
    """Read the table `name` and check its hashes, its columns, its values and its key.

    Parameters
    ----------
    path : Path
    name : str
    columns : sequence of Column
    remedy : str
        What the message advises.
    require_hash : bool
        Whether a table without a hash, as earlier versions wrote them, is refused.

    Raises
    ------
    TableError
        If the file is missing, damaged, too large, or another table, if values are missing or out
        of their range, or if two rows share a key. One line, with the remedy.
    """
    table, is_sealed = _read(path, name, columns, remedy)
    metadata = {
        key.decode("utf-8", "replace"): value.decode("utf-8", "replace")
        for key, value in (table.schema.metadata or {}).items()
    }
    if not is_sealed:
        if require_hash:
            raise TableError(f"{path}: {UNHASHED}: {remedy}")
    elif metadata.get(ROWS_HASH) != hash_rows(table):
        raise TableError(f"{path}: damaged, its content does not match its hash; {remedy}")
    stored_name = metadata.get("table", name)
    if stored_name != name:
        raise TableError(f"{path}: is the table {printable(stored_name)}, not {name}; {remedy}")
    frame = table.to_pandas()
    check_values(frame, columns, path, remedy)
    check_key(frame, [column.name for column in columns if column.key], path, remedy=remedy)
    return StoredTable(frame, {k: v for k, v in metadata.items() if k != "pandas"})


def _read(path: Path, name: str, columns: Sequence[Column], remedy: str) -> tuple[pa.Table, bool]:
    """Read a Parquet file of exactly these columns; also returns whether it has a seal."""
    expected = arrow_schema(columns)
    try:
        content = read_bounded(path, TableError, remedy, MAX_BYTES)
        if not (content.startswith(_MAGIC) and content.endswith(_MAGIC)):
            raise ValueError("its beginning or its end is missing")
        is_sealed = is_intact(content)
        if is_sealed is False:
            raise TableError(f"{path}: damaged, its content does not match its hash; {remedy}")
        found = pq.read_schema(pa.BufferReader(content))
        names = found.names  # decoded only here
        if names == expected.names and found.types == expected.types:
            return read_bounded_table(content), bool(is_sealed)
        earlier = arrow_schema(column for column in columns if not column.added)
        if is_sealed is None and (names, found.types) == (earlier.names, earlier.types):
            return _add_missing(read_bounded_table(content), expected), False
    except FileNotFoundError:
        raise TableError(
            f"{path}: there is no such table; run the workflow, or give the path of a {name} table"
        ) from None
    except TableTooLargeError as error:
        raise TableError(f"{path}: {error}; {remedy}") from None
    except UnicodeDecodeError:
        raise TableError(f"{path}: not a readable Parquet file (damaged text); {remedy}") from None
    except (pa.ArrowException, OSError, ValueError, OverflowError, MemoryError) as error:
        reason = (str(error).splitlines() or ["?"])[0][:120]
        raise TableError(
            f"{path}: not a readable Parquet file ({printable(reason)}); {remedy}"
        ) from None
    shown = printable(", ".join(names[:12])) + (", ..." if len(names) > 12 else "")
    raise TableError(f"{path}: not a {name} table, its columns are {shown:.300}; {remedy}")


def _add_missing(table: pa.Table, expected: pa.Schema) -> pa.Table:
    """A table of an earlier version with the columns that were added since, without values."""
    for i, field in enumerate(expected):
        if field.name not in table.schema.names:
            table = table.add_column(i, field.with_nullable(True), pa.nulls(len(table), field.type))
    return table


def check_values(
    frame: pd.DataFrame, columns: Sequence[Column], path: Path, remedy: str = REMEDY
) -> None:
    """Raise TableError if a value is missing where it must not be, or out of its range."""
    for column in columns:
        values = frame[column.name]
        problems = {}
        if not column.nullable and not (column.added and values.isna().all()):
            problems["has no value"] = values.isna()
        if column.lowest is not None:
            problems[f"is below {column.lowest:g}"] = values < column.lowest
            problems["is infinite"] = values == float("inf")
        if column.high is not None:
            problems[f"is above {column.high:g}"] = values > column.high
        for problem, wrong in problems.items():
            if wrong.any():
                first = int(wrong.to_numpy(bool).argmax())
                raise TableError(
                    f"{path}: {column.name} {problem} in {int(wrong.sum()):,} of {len(frame):,} "
                    f"rows, the first of them row {first}; {remedy}"
                )


def check_key(
    frame: pd.DataFrame, key: list[str], path: Path, culprit: str = "it", remedy: str = ""
) -> None:
    """Raise TableError if two rows of `frame` have the same values in the columns `key`.

    `culprit` says what to delete: by default the file `path` itself; `remedy` replaces the advice.
    """
    repeated = frame.duplicated(key) if key else pd.Series(False, frame.index)
    if repeated.any():
        first = frame.loc[repeated.idxmax(), key]
        where = ", ".join(f"{column} {value}" for column, value in first.items())
        raise TableError(
            f"{path}: {int(repeated.sum())} rows are repeated, the first with "
            f"{printable(where)}; {remedy or f'delete {culprit} and run again'}"
        )


def read_metadata(path: Path) -> dict[str, str]:
    """Metadata of a Parquet file, not checked: name of the table and where it comes from."""
    check_regular_file(path, TableError, "give a table")
    metadata = pq.read_schema(path).metadata or {}
    return {key.decode(): value.decode() for key, value in metadata.items()}


def has_column(path: Path, name: str) -> bool:
    """Whether a file is a table with this column; False if it cannot be read."""
    try:
        check_regular_file(path, TableError, "give a table")
        return name in pq.read_schema(path).names
    except (pa.ArrowException, OSError, ValueError, TableError):
        return False
