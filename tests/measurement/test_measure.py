"""measure(): known answers, the same distances however they are computed, and clear errors."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure

from sensory_commutativity import (
    ArgumentError,
    Corridor,
    Measurement,
    UserError,
    WorldError,
    action_scales,
    measure,
)
from sensory_commutativity.errors import TableError
from tests.scp.test_check import HasNoisySteps, RestoresNothing, ReturnsADictionary, Wrapped


class Slow(Corridor):
    """A corridor that takes its time."""

    def reset(self, rng):
        time.sleep(0.005)
        super().reset(rng)


@pytest.fixture(scope="module")
def measured() -> Measurement:
    return measure(Corridor(wall=1), n=60, length=5, thresholds=(0.0, 1.0))


def test_known_answers_in_the_corridor() -> None:
    free = measure(Corridor(), n=30, length=6)
    assert free.table["scp"].tolist() == [1.0, 1.0]
    blocked = measure(Corridor(wall=0), n=200, length=6).scp()
    assert blocked["eyelid"] == 1.0 and 0.1 < blocked["move"] < 0.9


def test_the_table_is_tidy(measured: Measurement) -> None:
    table = measured.table
    columns = ["dof", "threshold", "n", "commuted", "scp", "ci_low", "ci_high"]
    assert table.columns.tolist() == columns
    assert table["dof"].tolist() == ["move", "move", "eyelid", "eyelid"]
    assert table["threshold"].tolist() == [0.0, 1.0] * 2 and set(table["n"]) == {60}
    assert (table["ci_low"] <= table["scp"]).all() and (table["scp"] <= table["ci_high"]).all()
    assert len(measured.experiments) == 120 and len(measured) == 60


def test_an_experiment_does_not_depend_on_how_many_there_are(measured: Measurement) -> None:
    fewer = measure(Corridor(wall=1), n=20, length=5)
    assert np.array_equal(fewer.distances, measured.distances[:20])
    other = measure(Corridor(wall=1), n=60, length=5, seed=1)
    assert not np.array_equal(other.distances, measured.distances)


@pytest.mark.parametrize("source", [Corridor(wall=1), lambda: Corridor(wall=1)])
def test_workers_do_not_change_the_result(measured: Measurement, source) -> None:
    parallel = measure(source, n=60, length=5, workers=2)
    assert np.array_equal(parallel.distances, measured.distances)


def test_a_killed_worker_is_an_error() -> None:
    import os

    class Kills(Corridor):
        parent = os.getpid()

        def reset(self, rng):
            if os.getpid() != self.parent:
                os._exit(1)
            super().reset(rng)

    with pytest.raises(UserError, match=r"workers: a process was killed"):
        measure(Kills(wall=1), n=10, length=3, workers=2)


def test_order_tells_pairs_apart(measured: Measurement) -> None:
    order = measured.order()
    assert order.dofs == ("move", "eyelid") and order.ties == []
    pair = order.pairs.iloc[0]
    assert pair["only_lower"] == 0
    assert pair["only_higher"] == 60 - measured.table["commuted"].iloc[0]
    assert pair["difference"] == pytest.approx(
        measured.scp()["eyelid"] - measured.scp()["move"])  # fmt: skip
    assert "1 of 1 pairs differ significantly" in str(order)
    tied = measure(Corridor(), n=20, length=3).order()
    assert tied.ties == [("move", "eyelid")] and not tied.pairs["distinct"].any()


def test_scps_make_action_spaces(measured: Measurement) -> None:
    assert action_scales("truncated", measured.scp()) == {"move": 1.0, "eyelid": 0.0}


def test_other_thresholds_need_no_new_experiments(measured: Measurement) -> None:
    other = measured.with_thresholds(100.0)
    assert other.distances is measured.distances
    assert set(other.table["scp"]) == {1.0}


def test_what_was_saved_is_loaded(measured: Measurement, tmp_path: Path) -> None:
    loaded = Measurement.load(measured.save(tmp_path / "scp.parquet"))
    assert np.array_equal(loaded.distances, measured.distances)
    assert loaded.table.equals(measured.table)
    assert (loaded.dofs, loaded.settings, loaded.provenance) == (
        measured.dofs, measured.settings, measured.provenance)  # fmt: skip
    assert str(loaded) == str(measured)
    (tmp_path / "other.parquet").write_bytes(b"no table")
    with pytest.raises(TableError, match=r"other.parquet"):
        Measurement.load(tmp_path / "other.parquet")


def test_the_text_names_the_world_and_every_degree_of_freedom(measured: Measurement) -> None:
    text = repr(measured)
    assert text.startswith("SCP of Corridor: 60 starts, sequences of 5 actions")
    assert "move" in text and "eyelid" in text and "95 % interval" in text
    assert "<table" in measured._repr_html_()


def test_the_figure_shows_every_degree_of_freedom(measured: Measurement) -> None:
    ax = measured.plot(Figure().add_subplot())
    assert [label.get_text() for label in ax.get_yticklabels()] == ["move", "eyelid"]
    assert len(ax.get_legend().get_texts()) == 2
    alone = measured.with_thresholds(0).plot()
    assert alone.get_legend() is None
    plt.close(alone.figure)


def test_a_measurement_goes_on_from_its_file(measured: Measurement, tmp_path: Path) -> None:
    file = tmp_path / "scp.parquet"
    measure(Corridor(wall=1), n=25, length=5, resume=file)
    played = []

    class Counted(Corridor):
        def reset(self, rng):
            played.append(1)
            super().reset(rng)

    Counted.__name__ = "Corridor"
    more = measure(Counted(wall=1), n=60, length=5, resume=file, check=False)
    assert len(played) == 35 + 1  # and the first start, which tells worlds apart
    assert np.array_equal(more.distances, measured.distances)
    for other in (
        dict(world=Corridor(wall=1, box=1)), dict(length=6), dict(seed=1), dict(rest_steps=9)
    ):  # fmt: skip
        arguments = {**dict(world=Corridor(wall=1), length=5), **other}
        with pytest.raises(ArgumentError, match=r"resume: .* another measurement"):
            measure(n=60, resume=file, **arguments)


KILLED = """
import sys
from sensory_commutativity import measure
from sensory_commutativity.measurement import measure as module
from tests.measurement.test_measure import Slow
module.SAVE_EVERY = 0.05
measure(Slow(wall=1), n=2000, length=5, resume=sys.argv[1], workers=int(sys.argv[2]))
"""


@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_killed_measurement_resumes_with_the_same_table(tmp_path: Path, workers: str) -> None:
    file = tmp_path / "scp.parquet"
    root = Path(__file__).resolve().parents[2]
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(file), workers], cwd=root, stderr=subprocess.DEVNULL
    )
    end = time.monotonic() + 120
    while not file.exists() and time.monotonic() < end:
        time.sleep(0.05)
    children = subprocess.run(
        ["pgrep", "--parent", str(process.pid)], capture_output=True, text=True
    ).stdout.split()
    assert len(children) == (int(workers) if workers != "1" else 0)
    process.kill()
    process.wait()
    while any(Path(f"/proc/{child}").exists() for child in children) and time.monotonic() < end:
        time.sleep(0.05)
    assert time.monotonic() < end, "a worker outlived its parent"
    kept = len(Measurement.load(file))
    assert 0 < kept < 2000
    resumed = measure(Slow(wall=1), n=kept + 10, length=5, resume=file)
    whole = measure(Slow(wall=1), n=kept + 10, length=5)
    assert resumed.table.equals(whole.table)
    assert np.array_equal(resumed.distances, whole.distances)


def nan_distance(first, second) -> float:
    return float("nan")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(n=0), "n: expected a whole number, at least 1; got 0"),
        (dict(n=2.5), "n: .* got 2.5"),
        (dict(n=True), "n: .* got True"),
        (dict(length=0), "length: "),
        (dict(seed=-1), "seed: "),
        (dict(rest_steps=-1), "rest_steps: "),
        (dict(workers=0), "workers: "),
        (dict(thresholds=()), "thresholds: "),
        (dict(thresholds=(0, -1)), "thresholds: .* at least 0"),
        (dict(thresholds=(0, float("nan"))), "thresholds: "),
        (dict(thresholds="low"), "thresholds: expected numbers"),
        (dict(thresholds=(0, 0)), "thresholds: .* twice"),
        (dict(distance="msd"), "distance: there is no distance 'msd'; did you mean 'mse'"),
        (dict(distance=nan_distance), "distance: expected a number of at least 0, got nan"),
        (dict(distance=lambda a, b: 1.0), "distance: expected 0 for two equal observations"),
        (dict(distance="vgg16"), "distance: vgg16 compares RGB images"),
        (dict(resume="/nowhere/at/all.parquet"), "resume: there is no folder"),
        (dict(world="corridor"), r"world: .* make_world\('corridor'\)"),
        (dict(world=Corridor), r"world: .* the class Corridor"),
        (dict(world=7), "world: int has no reset"),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value.partition(":")[0],
)  # fmt: skip
def test_bad_arguments_are_named_with_the_remedy(arguments, message) -> None:
    arguments = {**dict(world=Corridor(wall=1), n=5, length=3), **arguments}
    with pytest.raises(ArgumentError, match=message) as raised:
        measure(**arguments)
    assert "\n" not in str(raised.value)


def test_a_distance_that_becomes_nan_is_an_error() -> None:
    values = iter([0.0] * 10 + [float("nan")] * 100)
    with pytest.raises(ArgumentError, match=r"distance: was nan in experiment"):
        measure(Corridor(), n=20, length=3, distance=lambda a, b: next(values))


@pytest.mark.parametrize("broken", [RestoresNothing, HasNoisySteps, ReturnsADictionary])
def test_worlds_that_break_a_promise_are_refused(broken) -> None:
    with pytest.raises(WorldError, match=f"{broken.__name__} breaks a promise"):
        measure(broken(), n=10)


def test_a_world_without_degrees_of_freedom_is_refused() -> None:
    world = Wrapped()
    world.dofs = ()
    with pytest.raises(ArgumentError, match=r"world: Wrapped has no degrees of freedom"):
        measure(world, n=10)
