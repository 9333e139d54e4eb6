"""Parquet tables: their columns, their metadata, and files that cannot be read."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sensory_commutativity.errors import TableError, UserError
from sensory_commutativity.storage.columns import BOOL, FLOAT, INT, INTERVAL, TEXT, Column
from sensory_commutativity.storage.tables import read_metadata, read_table, write_table

COLUMNS = (
    Column("dof", TEXT, "", "degree of freedom", key=True),
    Column("length", INT, "actions", "length of the sequences", key=True),
    Column("threshold", FLOAT, "1", "largest distance that counts as equal"),
    Column("free", BOOL, "", "whether nothing was touched"),
    *INTERVAL,
)
FRAME = pd.DataFrame(
    {"dof": ["head", "eyelid"], "length": [2**62, 1], "threshold": [5e-324, 1 / 3],
     "free": [True, False], "ci_low": [np.nan, 0.5], "ci_high": [np.nan, 0.5]}
)  # fmt: skip


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "deep" / "er" / "table.parquet"


def write(path: Path, frame: pd.DataFrame = FRAME, **metadata: str) -> None:
    write_table(path, "speeds", COLUMNS, frame, metadata)


def refuse(path: Path) -> str:
    """The message with which a file is refused: one line that names it."""
    with pytest.raises(TableError) as caught:
        read_table(path, "speeds", COLUMNS)
    message = str(caught.value)
    assert message.startswith(f"{path}: ") and "\n" not in message
    return message


def test_a_table_is_read_as_it_was_written(path):
    write(path)
    pd.testing.assert_frame_equal(read_table(path, "speeds", COLUMNS), FRAME)
    shuffled = FRAME[FRAME.columns[::-1]].assign(extra=1).set_index(pd.Index([7, 9]))
    write(path, shuffled)  # in the order of the columns, without index and further columns
    pd.testing.assert_frame_equal(read_table(path, "speeds", COLUMNS), FRAME)
    write(path, FRAME[:0])
    assert read_table(path, "speeds", COLUMNS).dtypes["length"] == np.int64


def test_the_file_holds_units_descriptions_and_metadata(path):
    write(path, profile="default", root_seed="7")
    field = pq.read_schema(path).field("length")
    assert field.metadata == {b"unit": b"actions", b"description": b"length of the sequences"}
    assert not field.nullable and pq.read_schema(path).field("ci_low").nullable
    metadata = read_metadata(path)
    assert len(metadata.pop("seal")[17:]) == len(metadata.pop("rows_sha256")) == 64
    assert metadata == {"table": "speeds", "profile": "default", "root_seed": "7"}


def test_equal_tables_are_equal_bytes(path, tmp_path):
    write(path)
    other = tmp_path / "other.parquet"
    write(other)
    assert other.read_bytes() == path.read_bytes()


def test_rows_that_do_not_fit_the_columns_are_not_written(path):
    for changes in (
        {"threshold": [np.nan, 0.5]},  # not nullable
        {"length": ["many", "few"]},
        {"length": [1.5, 2.5]},
        {"dof": [1, 2]},
    ):
        with pytest.raises((pa.ArrowException, ValueError, TypeError)):
            write(path, FRAME.assign(**changes))
    with pytest.raises(KeyError, match="threshold"):
        write(path, FRAME.drop(columns="threshold"))
    assert not path.parent.exists() or not os.listdir(path.parent)


def test_files_that_are_no_such_table_are_refused(path):
    assert issubclass(TableError, UserError)
    assert "there is no such table; run the workflow, or give the path of a speeds table" in (
        refuse(path)
    )
    write(path)
    whole = path.read_bytes()
    for size in (0, 3, 100, len(whole) - 1):
        path.write_bytes(whole[:size])
        assert "delete it and run again" in refuse(path), size
    for name in (b"thre\xff\xffold", b"threshoLd"):
        path.write_bytes(whole.replace(b"threshold", name))
        assert "delete it and run again" in refuse(path), name
    path.write_text("no table\n" * 100)
    assert "not a readable Parquet file" in refuse(path)
    write_table(path, "speeds", COLUMNS[:2], FRAME, {})
    assert "not a speeds table, its columns are dof, length; delete it" in refuse(path)
    FRAME.astype({"length": float}).to_parquet(path)
    assert "not a speeds table" in refuse(path)
    write(path, pd.concat([FRAME, FRAME[1:], FRAME[1:]]))
    assert "2 rows are repeated, the first with dof eyelid, length 1; delete it" in refuse(path)
