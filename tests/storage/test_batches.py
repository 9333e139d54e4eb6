"""batches.py: a kill loses the batch at hand and nothing else."""

from __future__ import annotations

from contextlib import suppress

import pandas as pd
import pytest

from sensory_commutativity.seeding import generator
from sensory_commutativity.storage.batches import forget_batches, in_batches, write_in_batches
from sensory_commutativity.storage.tables import read_about, read_table

TABLE = "flatland_experiments"


class Killed(BaseException):
    """Not an Exception: nothing catches it, like a signal."""


class Work:
    """Rows of units start <= i < stop; remembers what it was asked, and dies when it comes to unit `dies_at`."""

    def __init__(self, dies_at: int | None = None):
        self.dies_at, self.asked = dies_at, []

    def __call__(self, start: int, stop: int) -> pd.DataFrame:
        if self.dies_at is not None and start <= self.dies_at < stop:
            raise Killed
        self.asked.append((start, stop))
        rows = [
            ("room", "someone", 5, "head", i, i * 7, generator(1, i).random())
            for i in range(start, stop)
        ]
        return pd.DataFrame(
            rows, columns=["world", "agent", "length", "dof", "experiment", "seed", "distance"]
        )


@pytest.fixture
def run(tmp_path, tiny_config):
    """in_batches on a table file in an empty folder."""

    def run(
        work: Work,
        start: int = 0,
        stop: int = 10,
        settings: str = "a",
        batch: int = 3,
        name: str = "table.parquet",
    ) -> pd.DataFrame:
        return in_batches(TABLE, work, start, stop, tmp_path / name, tiny_config, settings, batch)

    return run


@pytest.mark.parametrize(
    ("start", "stop", "batch", "asked"),
    [(0, 10, 3, [(0, 3), (3, 6), (6, 9), (9, 10)]), (5, 9, 4, [(5, 9)]), (2, 5, 100, [(2, 5)])],
)
def test_batches_cover_the_units_once(run, start, stop, batch, asked):
    work = Work()
    frame = run(work, start, stop, batch=batch)
    assert work.asked == asked
    pd.testing.assert_frame_equal(frame, Work()(start, stop))


@pytest.mark.parametrize("batch", [1, 2, 7, 10, 50])
def test_the_result_does_not_depend_on_the_batch(run, batch):
    pd.testing.assert_frame_equal(run(Work(), batch=batch), Work()(0, 10))


def test_a_killed_run_resumes(run):
    killed = Work(dies_at=7)
    with pytest.raises(Killed):
        run(killed)
    assert killed.asked == [(0, 3), (3, 6)]
    again = Work()
    frame = run(again)
    assert again.asked == [(6, 9), (9, 10)]  # finished batches are not computed again
    pd.testing.assert_frame_equal(frame, Work()(0, 10))


def test_a_run_killed_again_and_again_gets_there(run):
    asked = []
    for dies_at in (0, 4, 9, None):
        work = Work(dies_at)
        with suppress(Killed):
            frame = run(work)
        asked += work.asked
    assert asked == [(0, 3), (3, 6), (6, 9), (9, 10)]
    pd.testing.assert_frame_equal(frame, Work()(0, 10))


def test_batches_of_other_settings_are_thrown_away(run, tmp_path):
    with pytest.raises(Killed):
        run(Work(dies_at=7), settings="a")
    other = Work()
    run(other, settings="b")
    assert other.asked[0] == (0, 3)
    back = Work()
    run(back, settings="a")
    assert back.asked[0] == (0, 3)
    assert len(list((tmp_path / ".table.parquet.batches").iterdir())) == 1  # nothing piles up


def test_batches_made_from_other_contents_are_thrown_away(tmp_path, tiny_config):
    source = tmp_path / "pictures.h5"
    asked = []
    for content, dies_at in (("a", 7), ("a", None), ("b", None)):
        source.write_text(content)
        work = Work(dies_at)
        with suppress(Killed):
            in_batches(TABLE, work, 0, 10, tmp_path / "table.parquet", tiny_config, "", 3, [source])
        asked.append(work.asked[0])
    assert asked == [(0, 3), (6, 9), (0, 3)]


def test_batches_of_another_version_are_thrown_away(run, monkeypatch):
    with pytest.raises(Killed):
        run(Work(dies_at=7))
    monkeypatch.setattr("sensory_commutativity.storage.batches.__version__", "99.0")
    other = Work()
    run(other)
    assert other.asked[0] == (0, 3)


@pytest.mark.parametrize("keep", [0, 10, -20])
def test_a_truncated_batch_is_computed_again(run, tmp_path, keep):
    run(Work())
    file = sorted(tmp_path.rglob("00000003-*.parquet"))[0]
    file.write_bytes(file.read_bytes()[:keep])
    again = Work()
    frame = run(again)
    assert again.asked == [(3, 6)]
    pd.testing.assert_frame_equal(frame, Work()(0, 10))


def test_rubbish_among_the_batches_does_not_matter(run, tmp_path):
    with pytest.raises(Killed):
        run(Work(dies_at=7))
    folder = tmp_path / ".table.parquet.batches"
    (folder / "rubbish").write_text("x")
    (folder / "old").mkdir()
    (folder / "old" / "batch.parquet").write_text("x")
    again = Work()
    run(again)
    assert again.asked == [(6, 9), (9, 10)]
    assert not (folder / "rubbish").exists() and not (folder / "old").exists()


def test_two_tables_in_a_folder_do_not_mix(run):
    with pytest.raises(Killed):
        run(Work(dies_at=7), name="one.parquet")
    other = Work()
    run(other, name="other.parquet")
    assert other.asked[0] == (0, 3)
    resumed = Work()
    run(resumed, name="one.parquet")
    assert resumed.asked[0] == (6, 9)


def test_batches_are_kept_until_they_are_forgotten(run, tmp_path):
    run(Work())
    nothing = Work(dies_at=0)
    run(nothing)
    assert nothing.asked == []
    forget_batches(tmp_path / "table.parquet")
    assert not list(tmp_path.iterdir())
    forget_batches(tmp_path / "table.parquet")  # nothing to forget is no error
    work = Work()
    run(work)
    assert work.asked[0] == (0, 3)


def test_nothing_looks_finished_before_it_is(run, tmp_path):
    with pytest.raises(Killed):
        run(Work(dies_at=7))
    assert not (tmp_path / "table.parquet").exists()
    assert [p.name for p in tmp_path.iterdir()] == [".table.parquet.batches"]


def test_a_table_is_written_with_what_is_told_of_it_and_its_batches_are_forgotten(
    tmp_path, tiny_config
):
    out = tmp_path / "table.parquet"
    with pytest.raises(Killed):
        write_in_batches(TABLE, Work(dies_at=7), 0, 10, out, tiny_config, "", 3)
    again = Work()
    write_in_batches(TABLE, again, 0, 10, out, tiny_config, "", 3, about={"eye": "made up"})
    assert again.asked == [(6, 9), (9, 10)] and list(tmp_path.iterdir()) == [out]
    pd.testing.assert_frame_equal(read_table(TABLE, out), Work()(0, 10), check_dtype=False)
    assert read_about(out)["eye"] == "made up"
