"""Parquet files that expand without end, and tables that are whole and wrong, are refused."""

from __future__ import annotations

import io
import resource
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner

from sensory_commutativity.cli import main
from sensory_commutativity.errors import TableError, UserError
from sensory_commutativity.measurement.measurement import COLUMNS, Measurement
from sensory_commutativity.runs.origin import read_origin
from sensory_commutativity.runs.verify import verify_run
from sensory_commutativity.storage import parquet
from sensory_commutativity.storage.columns import FLOAT, INT, TEXT, Column
from sensory_commutativity.storage.seal import SEAL, SEAL_KEY, seal
from sensory_commutativity.storage.tables import read_metadata, read_table, write_table
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.checks import metadata_of
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.flatland.tables.flatland_experiments import flatland_experiments
from sensory_commutativity.studies.flatland.tables.flatland_scp import flatland_scp
from sensory_commutativity.studies.registry import find_table
from tests.adversarial.kinds import experiment_rows, write_scp, write_shards
from tests.studies.examples import write_frame

NUMBERS = (Column("i", INT, "1", "number"), Column("x", FLOAT, "1", "number"))
TEXTS = (Column("text", TEXT, "", "text"),)


def sealed(table: pa.Table, **options) -> bytes:
    """A Parquet file with the hash of its content, as somebody who forges one would write it."""
    content = io.BytesIO()
    described = {"table": "t", "rows_sha256": "0" * 64, SEAL_KEY: SEAL}
    pq.write_table(table.replace_schema_metadata(described), content, **options)
    return seal(content.getvalue())


def columns_of(n: int, k: int = 2) -> pa.Table:
    zeros = pa.array(np.zeros(n, np.int64))
    return pa.table({f"c{i}": zeros for i in range(k)})


def hostile_tables() -> Iterator[tuple[str, tuple[Column, ...], bytes]]:
    """What each table is, the columns that are expected of it, and its content."""
    n = 30_000_000
    many = pa.table({"i": np.zeros(n, np.int64), "x": np.zeros(n)})
    yield "30 million rows in a few bytes", NUMBERS, sealed(many, compression="zstd")
    text = "a" * 200_000
    yield "many copies of one text", TEXTS, sealed(pa.table({"text": [text] * 60}))
    shared = pa.table({"text": [text[:100_000] + str(i) for i in range(500)]})
    yield (
        "texts by their beginnings",
        TEXTS,
        sealed(shared, use_dictionary=False, column_encoding={"text": "DELTA_BYTE_ARRAY"}),
    )
    yield "5,000 columns", NUMBERS, sealed(columns_of(1, 5000))
    nested = pa.table({"i": [[[1]]] * 5, "x": [{"a": 1}] * 5})
    yield "nested columns", NUMBERS, sealed(nested)
    yield "other types", NUMBERS, sealed(pa.table({"i": ["a"], "x": [b"b"]}))
    yield "times", NUMBERS, sealed(pa.table({"i": pa.array([1], pa.timestamp("s")), "x": [1.0]}))


def test_tables_of_other_types_and_sizes_are_refused_before_they_are_read(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet, "MAX_TEXT_BYTES", 10_000_000)
    path = tmp_path / "t.parquet"
    for what, columns, content in hostile_tables():
        path.write_bytes(content)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        start = time.monotonic()
        with pytest.raises(TableError) as caught:
            pytest.fail(f"{what}: {len(read_table(path, 't', columns))}")
        message = str(caught.value)
        assert message.startswith(f"{path}: ") and message.isprintable() and len(message) < 600
        assert time.monotonic() - start < 2, what
        used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        assert used < 500 * 1024, what


def wrong_experiments(config: Config) -> Iterator[tuple[str, pd.DataFrame]]:
    """Whole tables of experiments that are not those of the configuration."""
    good = experiment_rows(config)
    world, first = good["world"].iloc[0], good["experiment"] == 0
    yield "doubled", pd.concat([good, good])
    yield "a row doubled", pd.concat([good, good[:1]])
    yield "a part is missing", good[~first]
    yield "a row is missing", good[1:]
    yield "no rows", good[:0]
    yield "negative", good.assign(distance=-good["distance"] - 1)
    yield "infinite", good.assign(distance=np.inf)
    yield "an unknown world", good.replace({"world": {world: "moon"}})
    yield "an unknown degree of freedom", good.replace({"dof": {"head": "tail"}})
    yield "others in place of some", good.assign(experiment=good["experiment"] + 1)
    yield "a negative number", good.assign(seed=-1)


def test_whole_tables_that_are_wrong_are_refused_with_one_line(few_config, tmp_path):
    out = tmp_path / "scp.parquet"
    for what, frame in wrong_experiments(few_config):
        path = write_frame(flatland_experiments, few_config, tmp_path, frame)
        assert_refused(few_config, path, out, what)
    good = experiment_rows(few_config)
    missing = [  # the schema that we write allows none
        replace(column, nullable=True) if column.name == "distance" else column
        for column in flatland_experiments.columns
    ]
    metadata = metadata_of(flatland_experiments, few_config, None)
    path = tmp_path / "flatland_experiments.parquet"
    nulls = good.assign(distance=good["distance"].where(good["experiment"] > 0))
    write_table(path, "flatland_experiments", missing, nulls, metadata)
    assert_refused(few_config, path, out, "nulls")
    write_table(path, "flatland_trends", flatland_experiments.columns, good, metadata)
    assert_refused(few_config, path, out, "the name of another table")
    for key, value in (("profile", "paper"), ("root_seed", "1"), ("settings_sha256", "0" * 16)):
        described = {**metadata, key: value}
        write_table(path, "flatland_experiments", flatland_experiments.columns, good, described)
        assert_refused(few_config, path, out, key)
    content = io.BytesIO()
    pq.write_table(pa.Table.from_pandas(good, preserve_index=False), content)
    path.write_bytes(content.getvalue())
    assert_refused(few_config, path, out, "no hash")
    write_table(path, "flatland_experiments", flatland_experiments.columns, good, metadata)
    runner.write_product(flatland_scp, few_config, [path], out)


def assert_refused(config: Config, path: Path, out: Path, what: str) -> None:
    with pytest.raises(UserError) as caught:
        runner.write_product(flatland_scp, config, [path], out)
        pytest.fail(f"{what} was taken")
    message = str(caught.value)
    assert message.startswith(f"{path}: ") and message.isprintable(), what
    assert "sencom table flatland_experiments --config" in message, message
    assert not out.exists()


def test_a_table_of_the_same_columns_does_not_pass_for_another(few_config, tmp_path):
    _, scp = write_scp(few_config, tmp_path)
    sensitivity = find_table("flatland_sensitivity")
    columns = [column.name for column in sensitivity.columns]
    assert columns == [column.name for column in flatland_scp.columns]
    frame = runner.read_product(flatland_scp, few_config, scp)
    other = write_frame(sensitivity, few_config, tmp_path, frame)
    other.replace(scp)
    with pytest.raises(TableError, match="is the table flatland_sensitivity, not flatland_scp"):
        runner.read_product(flatland_scp, few_config, scp)


def test_parts_are_given_once_and_all_of_them(few_config, tmp_path):
    paths = write_shards(few_config, tmp_path)
    out = tmp_path / "flatland_experiments.parquet"
    a, b = paths[:2]

    def exchange() -> None:
        content = a.read_bytes()
        a.write_bytes(b.read_bytes())
        b.write_bytes(content)

    def copy() -> None:
        b.write_bytes(a.read_bytes())

    cases: list[tuple[list[Path], Callable[[], object]]] = [
        ([*paths, a], lambda: None), ([a, *paths[2:]], lambda: None), (paths[:-1], lambda: None),
        (paths, exchange), (paths, copy),
    ]  # fmt: skip
    for given, change in cases:
        change()
        with pytest.raises(UserError):
            runner.write_product(flatland_experiments, few_config, given, out)
        write_shards(few_config, tmp_path)
        assert not out.exists()
    runner.write_product(flatland_experiments, few_config, paths, out)


def test_measurements_without_rows_are_refused(tmp_path):
    path = tmp_path / "m.parquet"
    measured = Measurement.load(_measure(path))
    metadata = {
        key: value
        for key, value in read_metadata(path).items()
        if key not in ("table", "pandas", "rows_sha256", SEAL_KEY)
    }
    for frame in (measured.experiments[:0], measured.experiments[:-1]):
        write_table(path, "measurement", COLUMNS, frame, metadata)
        with pytest.raises(TableError, match="experiments are missing"):
            Measurement.load(path)


def _measure(path: Path) -> Path:
    from sensory_commutativity import Corridor, measure

    return measure(Corridor(), n=3, length=3, check=False).save(path)


def test_what_files_say_is_printed_without_control_characters(tmp_path):
    bad = "\x1b]0;owned\x07\x1b[2Jabc\nroot_seed  0\u202e"
    run = tmp_path / "run"
    path = run / "tables" / "flatland_trends.parquet"
    write_table(path, "t", TEXTS, pd.DataFrame({"text": ["a"]}),
                {"config_sha256": "1", "git_commit": bad, bad: "x", "root_seed": "7"})  # fmt: skip
    (run / "figures").mkdir()
    (run / "figures" / f"{bad.replace('/', '')}.png").write_bytes(b"x")
    for arguments in (["provenance", path], ["verify", run], ["compare", run, run]):
        result = CliRunner().invoke(main, ["run", *map(str, arguments)])
        text = result.output + str(result.exception or "")
        lines = text.splitlines()
        assert all(line.isprintable() for line in lines), arguments
        assert not any(line.startswith("root_seed  0") for line in lines)
    assert read_origin(path)["git_commit"] == bad
    assert verify_run(run).bad
