"""Tables in Parquet files: tidy, with units and provenance in the file's own metadata."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import TableError
from .atomic import atomic_write
from .columns import Column, arrow_schema


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
    table = table.replace_schema_metadata({"table": name, **metadata})
    with atomic_write(path) as temporary:
        pq.write_table(table, temporary, compression="zstd")


def read_table(path: Path, name: str, columns: Sequence[Column]) -> pd.DataFrame:
    """Read the table `name` and check its columns and its key.

    Raises
    ------
    TableError
        If the file is missing, damaged or another table, or if two rows share a key. One line,
        with the remedy.
    """
    try:
        table = pq.read_table(path)
        names = table.schema.names  # decoded only here
    except FileNotFoundError:
        raise TableError(
            f"{path}: there is no such table; run the workflow, or give the path of a {name} table"
        ) from None
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0]
        raise TableError(
            f"{path}: not a readable Parquet file ({reason}); delete it and run again"
        ) from None
    except UnicodeDecodeError:
        raise TableError(
            f"{path}: not a readable Parquet file (damaged text); delete it and run again"
        ) from None
    expected = arrow_schema(columns)
    if names != expected.names or table.schema.types != expected.types:
        raise TableError(
            f"{path}: not a {name} table, its columns are {', '.join(names)}; "
            "delete it and run again"
        )
    frame = table.to_pandas()
    check_key(frame, [column.name for column in columns if column.key], path)
    return frame


def check_key(frame: pd.DataFrame, key: list[str], path: Path, culprit: str = "it") -> None:
    """Raise TableError if two rows of `frame` have the same values in the columns `key`.

    `culprit` says what to delete: by default the file `path` itself.
    """
    repeated = frame.duplicated(key) if key else pd.Series(False, frame.index)
    if repeated.any():
        first = frame.loc[repeated.idxmax(), key]
        where = ", ".join(f"{column} {value}" for column, value in first.items())
        raise TableError(
            f"{path}: {int(repeated.sum())} rows are repeated, the first with {where}; "
            f"delete {culprit} and run again"
        )


def read_metadata(path: Path) -> dict[str, str]:
    """Metadata of a Parquet file: name of the table and where it comes from."""
    metadata = pq.read_schema(path).metadata or {}
    return {key.decode(): value.decode() for key, value in metadata.items()}


def has_column(path: Path, name: str) -> bool:
    """Whether a file is a table with this column; False if it cannot be read."""
    try:
        return name in pq.read_schema(path).names
    except (pa.ArrowException, OSError, UnicodeDecodeError):
        return False
