"""tables.py and provenance.py: what stands in a table's file, and that a file is whole or not there."""

from __future__ import annotations

import hashlib
import json
import os
import stat
import subprocess
import sys

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sensory_commutativity.errors import TableError, UserError
from sensory_commutativity.storage import provenance as provenance_module
from sensory_commutativity.storage.provenance import provenance
from sensory_commutativity.storage.tables import (
    TABLES,
    read_table,
    schema,
    write_table,
    written_whole,
)

EXAMPLES = {
    pa.string(): ["a", "b"],
    pa.int64(): [1, 2],
    pa.float64(): [0.5, 0.25],
    pa.bool_(): [True, False],
}
SCP = "flatland_scp"


def example(name: str) -> pd.DataFrame:
    return pd.DataFrame({column.name: EXAMPLES[column.type] for column in TABLES[name]})


# ---- what the design promises ----------------------------------------------------------------------------------------------

PROMISED = {  # design.md, section 3
    "flatland_experiments": "world, agent, dof, experiment, seed, distance",
    "flatland_scp": "world, agent, dof, threshold, n, commuted, scp, ci_low, ci_high",
    "flatland_baselines": "dof, naive_mse, prediction_mse, excess_error, n_transitions",
    "flatland_commutation": "dof_a, dof_b, n, commuted, probability, ci_low, ci_high",
    "paper_comparison": "claim, section, paper_value, our_value, ci_low, ci_high, holds",
}


@pytest.mark.parametrize("name", PROMISED)
def test_tables_have_the_promised_columns(name):
    assert set(PROMISED[name].split(", ")) <= set(schema(name).names)


@pytest.mark.parametrize("name", TABLES)
def test_every_column_has_a_unit_or_is_text_and_is_described(name):
    names = schema(name).names
    assert len(set(names)) == len(names)
    for field in schema(name):
        assert len(field.metadata[b"description"]) > 2
        if field.type in (pa.int64(), pa.float64()):
            assert field.metadata[b"unit"]
            assert (
                not field.name.startswith("ci_") or field.nullable
            )  # not every value has an interval
        if field.type != pa.float64():
            assert not field.nullable


# ---- writing and reading ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", TABLES)
def test_round_trip(name, tmp_path, tiny_config):
    frame = example(name)
    write_table(name, frame, tmp_path / "deep" / "er" / "table.parquet", tiny_config)
    found = read_table(name, tmp_path / "deep" / "er" / "table.parquet")
    pd.testing.assert_frame_equal(found, frame)
    assert read_table(name, str(tmp_path / "deep" / "er" / "table.parquet")).equals(found)


def test_large_seeds_and_tiny_distances_survive(tmp_path, tiny_config):
    frame = example("flatland_experiments").assign(seed=[2**63 - 1, 0], distance=[5e-324, 1 / 3])
    write_table("flatland_experiments", frame, tmp_path / "t.parquet", tiny_config)
    pd.testing.assert_frame_equal(read_table("flatland_experiments", tmp_path / "t.parquet"), frame)


def test_columns_come_in_the_schema_s_order_and_the_index_is_left_out(tmp_path, tiny_config):
    frame = example(SCP)
    shuffled = frame[frame.columns[::-1]].assign(extra=1).set_index(pd.Index([7, 9]))
    write_table(SCP, shuffled, tmp_path / "t.parquet", tiny_config)
    pd.testing.assert_frame_equal(read_table(SCP, tmp_path / "t.parquet"), frame)


def test_the_file_itself_holds_units_and_where_it_comes_from(tmp_path, tiny_config):
    write_table(SCP, example(SCP), tmp_path / "t.parquet", tiny_config)
    found = pq.read_schema(tmp_path / "t.parquet")
    assert found.field("length").metadata == {
        b"unit": b"actions",
        b"description": b"length of the sequences",
    }
    metadata = {key.decode(): value.decode() for key, value in found.metadata.items()}
    assert metadata["table"] == SCP
    assert metadata["config_sha256"] == tiny_config.digest()
    assert metadata["root_seed"] == str(tiny_config.seed)
    assert metadata["profile"] == tiny_config.profile
    assert set(metadata) >= {"git_commit", "python", "platform", "packages"}
    assert set(json.loads(metadata["packages"])) >= {
        "numpy",
        "pymunk",
        "numba",
        "scipy",
        "torch",
        "sensory-commutativity",
    }


def test_writing_twice_gives_the_same_bytes(tmp_path, tiny_config):
    digests = set()
    for name in ("one.parquet", "other.parquet", "one.parquet"):
        write_table(SCP, example(SCP), tmp_path / name, tiny_config)
        digests.add(hashlib.sha256((tmp_path / name).read_bytes()).hexdigest())
    assert len(digests) == 1


def test_an_interval_may_be_missing_and_an_scp_not(tmp_path, tiny_config):
    frame = example(SCP)
    write_table(
        SCP,
        frame.assign(ci_low=[np.nan, 0.5], ci_high=[None, 0.5]),
        tmp_path / "t.parquet",
        tiny_config,
    )
    assert read_table(SCP, tmp_path / "t.parquet")["ci_low"].isna().tolist() == [True, False]
    with pytest.raises(ValueError, match="scp"):
        write_table(SCP, frame.assign(scp=[np.nan, 0.5]), tmp_path / "u.parquet", tiny_config)
    assert os.listdir(tmp_path) == ["t.parquet"]


@pytest.mark.parametrize(
    "bad", [{"n": ["many", "few"]}, {"n": [1.5, 2.5]}, {"dof": [1, 2]}], ids=str
)
def test_wrong_types_are_not_written(bad, tmp_path, tiny_config):
    with pytest.raises((pa.ArrowException, ValueError, TypeError)):
        write_table(SCP, example(SCP).assign(**bad), tmp_path / "t.parquet", tiny_config)
    assert not os.listdir(tmp_path)


def test_a_missing_column_is_not_written(tmp_path, tiny_config):
    with pytest.raises(KeyError, match="scp"):
        write_table(SCP, example(SCP).drop(columns="scp"), tmp_path / "t.parquet", tiny_config)
    assert not os.listdir(tmp_path)


# ---- what cannot be read ---------------------------------------------------------------------------------------------------


def refused(path) -> str:
    with pytest.raises(TableError) as caught:
        read_table(SCP, path)
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    return message


def test_a_missing_table(tmp_path):
    message = refused(tmp_path / "gone.parquet")
    assert "no such table" in message and SCP in message
    assert issubclass(TableError, UserError)


@pytest.mark.parametrize("keep", [0, 3, 100, -1])
def test_a_truncated_table(keep, tmp_path, tiny_config):
    path = tmp_path / "t.parquet"
    write_table(SCP, example(SCP), path, tiny_config)
    path.write_bytes(path.read_bytes()[:keep])
    assert "delete it" in refused(path)


def test_garbage_instead_of_a_table(tmp_path):
    path = tmp_path / "t.parquet"
    path.write_text("no table\n" * 100)
    assert "not a readable Parquet file" in refused(path)


@pytest.mark.parametrize("instead", [b"thre\xff\xffold", b"threshoLd"])
def test_damaged_names(instead, tmp_path, tiny_config):
    path = tmp_path / "t.parquet"
    write_table(SCP, example(SCP), path, tiny_config)
    path.write_bytes(path.read_bytes().replace(b"threshold", instead))
    assert "delete it" in refused(path)


def test_another_table(tmp_path, tiny_config):
    path = tmp_path / "t.parquet"
    write_table("flatland_baselines", example("flatland_baselines"), path, tiny_config)
    assert f"not a {SCP} table" in refused(path) and "naive_mse" in refused(path)


def test_the_right_names_with_the_wrong_types(tmp_path):
    path = tmp_path / "t.parquet"
    example(SCP).astype({"n": float}).to_parquet(path)
    assert f"not a {SCP} table" in refused(path)


# ---- written_whole ---------------------------------------------------------------------------------------------------------


def test_a_file_gets_its_name_when_it_is_finished(tmp_path):
    path = tmp_path / "a" / "file.txt"
    with written_whole(path) as temporary:
        assert temporary.parent == path.parent  # renaming works within one file system only
        assert temporary.suffix == ".txt"
        temporary.write_text("half")
        assert not path.exists()
        temporary.write_text("whole")
    assert path.read_text() == "whole"
    assert os.listdir(path.parent) == ["file.txt"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
def test_a_failed_file_leaves_nothing(error, tmp_path):
    path = tmp_path / "file.txt"
    with pytest.raises(error), written_whole(path) as temporary:
        temporary.write_text("half")
        raise error
    assert not os.listdir(tmp_path)


def test_a_failed_file_leaves_the_old_one(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old")
    with pytest.raises(ValueError, match="no"), written_whole(path) as temporary:
        temporary.write_text("half")
        raise ValueError("no")
    assert path.read_text() == "old"
    with written_whole(path) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"
    assert os.listdir(tmp_path) == ["file.txt"]


def test_what_a_killed_writer_left_is_cleared_away(tmp_path):
    code = (
        "import os, sys, pathlib; from sensory_commutativity.tables import written_whole\n"
        "with written_whole(pathlib.Path(sys.argv[1])) as temporary:\n"
        "    temporary.write_text('half'); os._exit(9)"
    )
    path, other = tmp_path / "file[1].txt", tmp_path / "other.txt"
    for killed in (path, other):
        assert subprocess.run([sys.executable, "-c", code, str(killed)]).returncode == 9
    assert len(os.listdir(tmp_path)) == 2
    assert not path.exists()  # what looks finished is
    with written_whole(path) as temporary:
        temporary.write_text("whole")
    assert path.read_text() == "whole"
    assert (
        len(os.listdir(tmp_path)) == 2
    )  # and what another file's writer left is none of its business


@pytest.mark.parametrize(("umask", "mode"), [(0o022, 0o644), (0o077, 0o600), (0o002, 0o664)])
def test_the_file_has_the_usual_permissions(umask, mode, tmp_path):
    before = os.umask(umask)
    try:
        with written_whole(tmp_path / "file.txt") as temporary:
            temporary.write_text("x")
        assert stat.S_IMODE((tmp_path / "file.txt").stat().st_mode) == mode
        assert os.umask(umask) == umask  # asking for the umask did not change it
    finally:
        os.umask(before)


# ---- provenance ------------------------------------------------------------------------------------------------------------


def test_provenance_is_the_same_for_every_table_of_a_run(tiny_config):
    assert provenance(tiny_config) == provenance(tiny_config)
    assert all(isinstance(value, str) and value for value in provenance(tiny_config).values())


def test_no_git_no_commit(monkeypatch):
    provenance_module._git_commit.cache_clear()
    monkeypatch.setenv("PATH", "/nowhere")
    try:
        assert provenance_module._git_commit() == "unknown"
    finally:
        provenance_module._git_commit.cache_clear()
