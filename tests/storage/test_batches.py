"""Batches: a killed job loses at most the batch that it was working on."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import pandas as pd
import pytest

from sensory_commutativity.seeding import generator
from sensory_commutativity.storage.batches import compute_in_batches, remove_batches
from sensory_commutativity.storage.columns import FLOAT, INT, Column
from sensory_commutativity.storage.tables import read_metadata

COLUMNS = (
    Column("unit", INT, "1", "number of the unit", key=True),
    Column("value", FLOAT, "1", "a random number"),
)


class Killed(BaseException):
    """Not an Exception: like a signal, nothing catches it."""


class Work:
    """Computes rows of units, records the batches, and is killed at the unit `killed_at`."""

    def __init__(self, killed_at: int | None = None):
        self.killed_at = killed_at
        self.batches: list[tuple[int, int]] = []

    def __call__(self, start: int, stop: int) -> pd.DataFrame:
        if self.killed_at is not None and start <= self.killed_at < stop:
            raise Killed
        self.batches.append((start, stop))
        values = [generator(1, i).random() for i in range(start, stop)]
        return pd.DataFrame({"unit": range(start, stop), "value": values})


@pytest.fixture
def run(tmp_path) -> Callable[..., pd.DataFrame]:
    """compute_in_batches of units 0 to 9 in batches of 3."""

    def run(work, units=(0, 10), settings="a", batch=3, name="table.parquet", **options):
        return compute_in_batches(
            tmp_path / name, "numbers", COLUMNS, work, units, settings, batch, **options
        )

    return run


def kill(run, at: int = 7, **options) -> None:
    """A run that is killed at a unit; by default, batches 0-3 and 3-6 are complete."""
    with pytest.raises(Killed):
        run(Work(at), **options)


def resume(run, **options) -> list[tuple[int, int]]:
    """Batches that a run computes until it is complete."""
    work = Work()
    pd.testing.assert_frame_equal(run(work, **options), Work()(0, 10))
    return work.batches


def test_batches_cover_all_units_once(run):
    cases = (
        ((0, 10), 3, [(0, 3), (3, 6), (6, 9), (9, 10)]),
        ((5, 9), 4, [(5, 9)]),
        ((2, 5), 100, [(2, 5)]),
    )
    for units, batch, expected in cases:
        work = Work()
        rows = run(work, units, batch=batch, name=f"{units[0]}.parquet")
        assert work.batches == expected
        pd.testing.assert_frame_equal(rows, Work()(*units))


def test_rows_do_not_depend_on_the_size_of_batches(run):
    for batch in (1, 2, 7, 10, 50):
        rows = run(Work(), batch=batch, name=f"{batch}.parquet")
        pd.testing.assert_frame_equal(rows, Work()(0, 10))


def test_a_killed_run_resumes(run, tmp_path):
    kill(run)
    assert [path.name for path in tmp_path.iterdir()] == [".table.parquet.batches"]
    assert resume(run) == [(6, 9), (9, 10)]


def test_a_run_that_is_killed_several_times_computes_each_batch_once(run):
    batches = []
    for killed_at in (0, 4, 9, None):
        work = Work(killed_at)
        with suppress(Killed):
            rows = run(work)
        batches += work.batches
    assert batches == [(0, 3), (3, 6), (6, 9), (9, 10)]
    pd.testing.assert_frame_equal(rows, Work()(0, 10))


def test_batches_of_other_settings_versions_and_sources_are_removed(run, tmp_path, monkeypatch):
    source = tmp_path / "images.h5"
    source.write_text("a")
    kill(run, sources=[source])
    assert resume(run, sources=[source])[0] == (6, 9)
    source.write_text("b")
    kill(run, sources=[source])
    kill(run, settings="b", sources=[source])
    assert resume(run, settings="a", sources=[source])[0] == (0, 3)
    remove_batches(tmp_path / "table.parquet")
    kill(run)
    monkeypatch.setattr("sensory_commutativity.storage.batches.__version__", "99.0")
    assert resume(run)[0] == (0, 3)
    assert len(list((tmp_path / ".table.parquet.batches").iterdir())) == 1  # nothing accumulates


def test_a_truncated_batch_is_computed_again(run, tmp_path):
    run(Work())
    file = next(tmp_path.rglob("00000003-*.parquet"))
    content = file.read_bytes()
    for size in (0, 10, len(content) - 20):
        file.write_bytes(content[:size])
        assert resume(run) == [(3, 6)], size


def test_other_files_among_the_batches_are_removed(run, tmp_path):
    kill(run)
    folder = tmp_path / ".table.parquet.batches"
    (folder / "file").write_text("x")
    (folder / "old").mkdir()
    (folder / "old" / "batch.parquet").write_text("x")
    assert resume(run) == [(6, 9), (9, 10)]
    assert not (folder / "file").exists() and not (folder / "old").exists()


def test_tables_in_one_folder_have_separate_batches(run):
    kill(run, name="a.parquet")
    assert resume(run, name="b.parquet")[0] == (0, 3)
    assert resume(run, name="a.parquet")[0] == (6, 9)


def test_batches_are_kept_with_their_metadata_until_they_are_removed(run, tmp_path):
    run(Work(), metadata={"camera": "left"})
    batch = next(tmp_path.rglob("00000003-*.parquet"))
    assert read_metadata(batch)["camera"] == "left"
    assert resume(run) == []
    for _ in range(2):  # without batches there is nothing to do
        remove_batches(tmp_path / "table.parquet")
        assert not list(tmp_path.iterdir())
    assert resume(run)[0] == (0, 3)
