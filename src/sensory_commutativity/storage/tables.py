"""How tables are written and read."""

from __future__ import annotations

import errno
import glob
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import TableError, UserError
from ..studies.config import Config
from ..studies.schema_apartment import APARTMENT
from ..studies.schema_flatland import FLATLAND
from ..studies.schema_masks import MASKS
from ..studies.schema_navigation import NAVIGATION
from .columns import BOOL, FLOAT, NULLABLE, TEXT, Column, Tables
from .provenance import provenance

PAPER: Tables = {
    "paper_comparison": (
        Column("claim", TEXT, "", "what the paper says"),
        Column("section", TEXT, "", "where"),
        Column("paper_value", TEXT, "", "the paper's value, as far as it gives one"),
        Column("our_value", TEXT, "", "what this run measured"),
        Column(
            "ci_low", FLOAT, "1", "lower end of the 95 % interval, where the value is one number"
        ),
        Column(
            "ci_high", FLOAT, "1", "upper end of the 95 % interval, where the value is one number"
        ),
        Column("holds", BOOL, "", "whether the claim holds in this run"),
    ),
}

TABLES: Tables = {**FLATLAND, **APARTMENT, **MASKS, **NAVIGATION, **PAPER}


def schema(name: str) -> pa.Schema:
    """The Arrow schema of the table `name`, units and descriptions in each field's metadata."""
    fields = [
        pa.field(
            c.name,
            c.type,
            nullable=c.name in NULLABLE,
            metadata={"unit": c.unit, "description": c.description},
        )
        for c in TABLES[name]
    ]
    return pa.schema(fields)


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path` to write to; it gets its final name only when all went well. Raises UserError when the disk is full."""
    path.parent.mkdir(parents=True, exist_ok=True)
    for left in path.parent.glob(
        f".{glob.escape(path.name)}.*.part*"
    ):  # by a process that was killed
        left.unlink(missing_ok=True)
    handle, temporary = tempfile.mkstemp(
        prefix=f".{path.name}.", suffix=f".part{path.suffix}", dir=path.parent
    )
    os.close(handle)
    try:
        yield Path(temporary)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        raise UserError(
            f"{path}: cannot be written: {os.strerror(error.errno)}; make room, and run the workflow again"
        ) from None
    finally:
        Path(temporary).unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_table(
    name: str,
    frame: pd.DataFrame,
    path: str | Path,
    config: Config,
    about: Mapping[str, str] | None = None,
) -> None:
    """Write `frame` as the table `name`; its columns must be those of the schema. What else it comes from, `about`, stands beside the provenance."""
    table = pa.Table.from_pandas(
        frame[[c.name for c in TABLES[name]]], schema(name), preserve_index=False
    )
    table = table.replace_schema_metadata({"table": name, **provenance(config), **(about or {})})
    with written_whole(Path(path)) as temporary:
        pq.write_table(table, temporary, compression="zstd")


def read_table(name: str, path: str | Path) -> pd.DataFrame:
    """Read the table `name`. Raises TableError when the file is missing, damaged or another table."""
    try:
        table = pq.read_table(path)
        names = table.schema.names  # decoded only now
    except FileNotFoundError:
        raise TableError(
            f"{path}: there is no such table; run the workflow, or give the path of a {name} table"
        ) from None
    except (pa.ArrowException, OSError) as error:
        raise TableError(
            f"{path}: not a readable Parquet file ({str(error).splitlines()[0]}); delete it and run again"
        ) from None
    except UnicodeDecodeError:
        raise TableError(
            f"{path}: not a readable Parquet file (damaged text); delete it and run again"
        ) from None
    expected = schema(name)
    if names != expected.names or table.schema.types != expected.types:
        raise TableError(
            f"{path}: not a {name} table, its columns are {', '.join(names)}; delete it and run again"
        )
    return table.to_pandas()


def read_about(path: str | Path) -> dict[str, str]:
    """What a table that :func:`read_table` can read says of where it comes from."""
    return {
        key.decode(): value.decode() for key, value in (pq.read_schema(path).metadata or {}).items()
    }
