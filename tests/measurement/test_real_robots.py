"""measure() without a restore, until the order is decided, and from logs."""

from __future__ import annotations

import json

import gymnasium
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from sensory_commutativity import (
    ArgumentError,
    Corridor,
    Dof,
    FlatlandWorld,
    Measurement,
    Recorder,
    Room,
    UserError,
    WorldError,
    from_gymnasium,
    measure,
    measure_log,
    write_log,
)
from sensory_commutativity.adapters.noise import NoisyWorld
from sensory_commutativity.errors import TableError
from tests.scp.test_return_protocol import OnlySteps

RELATIVE = ["control", "relative", "relative_low", "relative_high", "p", "start_seen_again"]


class Walls:
    """Three slides: a stop is near, far, or nowhere."""

    dofs = tuple(Dof(name, "1", 1.0) for name in ("near", "far", "free"))

    def reset(self, rng):
        self._place = np.zeros(3)

    def snapshot(self):
        return self._place.copy()

    def restore(self, snapshot):
        self._place = snapshot.copy()

    def step(self, action):
        self._place = np.minimum(self._place + np.sign(action), [0, 3, np.inf])

    def observe(self):
        return self._place.copy()


# ---- the return protocol --------------------------------------------------------------------


def test_a_world_that_only_steps_is_measured_with_its_control() -> None:
    found = measure(OnlySteps(wall=1), n=20, length=5, protocol="return")
    assert found.settings.protocol == "return" and len(found) == 20
    assert set(RELATIVE) <= set(found.table.columns)
    assert found.scp()["eyelid"] == 1.0
    assert "return protocol" in str(found) and "relative" in str(found)
    assert found.order().dofs[-1] == "eyelid"


def test_resets_between_starts_and_one_life_differ() -> None:
    """Behind the first blocked step the corridor is never the same again."""
    often = measure(Corridor(wall=1), n=40, length=5, protocol="return", reset_every=1)
    once = measure(Corridor(wall=1), n=40, length=5, protocol="return", wander=0)
    assert often.table["start_seen_again"].iloc[0] < once.table["start_seen_again"].iloc[0]
    again = measure(Corridor(wall=1), n=40, length=5, protocol="return", reset_every=1)
    assert np.array_equal(often.distances, again.distances)


def test_under_noise_the_control_says_that_nothing_is_meant() -> None:
    world = NoisyWorld(FlatlandWorld(Room(objects=0, walls=False)), sensor=5.0)
    found = measure(world, n=12, length=10, protocol="return", thresholds=(0, 1e5)).table
    assert set(found.loc[found["threshold"] == 0, "scp"]) == {0.0}
    far = found[found["threshold"] == 1e5]
    assert set(far["relative"]) == {1.0} and set(far["p"]) == {1.0}


def test_an_environment_is_never_restored() -> None:
    env = gymnasium.make("Reacher-v5")
    found = measure(env, n=2, length=10, protocol="return")
    assert "state never restored" in found.choices
    assert "way back: the inverse of every action is known" in found.choices
    assert (found.distances < 0.01).all()
    world = from_gymnasium(gymnasium.make("Reacher-v5"), snapshots="none")
    world.reset(np.random.default_rng(0))
    with pytest.raises(WorldError, match="nothing can be restored"):
        world.restore(world.snapshot())


def test_a_file_holds_everything(tmp_path) -> None:
    file = tmp_path / "scp.parquet"
    found = measure(Corridor(wall=1), n=12, length=5, protocol="return", resume=file)
    loaded = Measurement.load(file)
    assert loaded.table.equals(found.table) and str(loaded) == str(found)
    with pytest.raises(ArgumentError, match="one life cannot go on from"):
        measure(Corridor(wall=1), n=12, length=5, protocol="return", resume=file)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(protocol="backward"), "protocol: expected one of reset, return; got 'backward'"),
        (dict(protocol="return", workers=2), "workers: one life is played start after start"),
        (dict(protocol="return", reset_every=0), "reset_every: expected a whole number"),
        (dict(protocol="return", wander=-1), "wander: expected a whole number"),
        (dict(reset_every=3), "reset_every: every experiment of the protocol reset"),
        (dict(until="tired"), "until: expected 'ordered' or None"),
        (dict(until="ordered", alpha=1.0), "alpha: expected a number between 0 and 1"),
        (dict(until="ordered", margin=0), "margin: expected a number between 0 and 1"),
        (dict(until="ordered", workers=2), "workers: a measurement until ordered"),
    ],
)
def test_bad_arguments_are_named(arguments, message) -> None:
    with pytest.raises(ArgumentError, match=message):
        measure(Corridor(wall=1), **{**dict(n=5, length=3), **arguments})


def test_forces_have_no_known_inverse() -> None:
    with pytest.raises(ArgumentError, match="protocol: the inverse of no action is known"):
        measure(gymnasium.make("Pendulum-v1"), n=2, protocol="return")
    with pytest.raises(WorldError, match="has no step, dofs"):
        blind = type("Blind", (), {"observe": lambda self: None})()
        measure(blind, n=2, protocol="return")


# ---- until the order is decided ---------------------------------------------------------------


def test_sampling_stops_when_the_order_is_decided() -> None:
    found = measure(Corridor(wall=0), n=5000, length=6, until="ordered")
    assert len(found) <= 60
    order = found.order()
    assert order.dofs == ("move", "eyelid") and order.ties == [] and order.undecided == []
    assert order.pairs["distinct"].all()
    assert "1 of 1 pairs are ordered, 0 tied" in str(order)
    # The experiments that were played are those of a fixed number of them.
    fixed = measure(Corridor(wall=0), n=len(found), length=6)
    assert np.array_equal(found.distances, fixed.distances)


def test_ties_are_found_and_what_is_decided_is_not_played_on(tmp_path) -> None:
    free = measure(Corridor(), n=5000, length=4, until="ordered", margin=0.1).order()
    assert free.ties == [("move", "eyelid")] and not free.pairs["distinct"].any()
    few = measure(Corridor(), n=20, length=4, until="ordered").order()
    assert few.undecided == [("move", "eyelid")] and "not decided: move and eyelid" in str(few)
    file = tmp_path / "scp.parquet"
    found = measure(Walls(), n=400, length=6, until="ordered", alpha=0.2, resume=file)
    assert found.order().dofs == ("near", "far", "free")
    n = found.table.set_index("dof")["n"]
    assert n.nunique() > 1 and len(found.experiments) == n.sum()
    loaded = Measurement.load(file)
    assert str(loaded) == str(found) and str(loaded.order()) == str(found.order())
    with pytest.raises(ArgumentError, match="threshold: sampling stopped by the order at 0"):
        found.order(5.0)


def test_a_life_can_be_lived_until_ordered() -> None:
    found = measure(
        Corridor(wall=0), n=400, length=6, protocol="return", reset_every=1, until="ordered"
    )
    assert len(found) < 400 and {"relative", "n"} <= set(found.table.columns)


# ---- logs ---------------------------------------------------------------------------------------

WORLDS = {
    "flatland": lambda: FlatlandWorld(Room(objects=10)),
    "corridor": lambda: Corridor(wall=1, box=1),
    "reacher": lambda: from_gymnasium(gymnasium.make("Reacher-v5"), snapshots="none"),
}


@pytest.mark.parametrize("name", list(WORLDS))
def test_live_and_from_its_log_the_tables_are_identical(name, tmp_path) -> None:
    live = measure(WORLDS[name](), n=3, length=10, protocol="return")
    recorder = Recorder(WORLDS[name]())
    recorded = measure(recorder, n=3, length=10, protocol="return")
    log = measure_log(write_log(tmp_path / "log.parquet", recorder, live.settings.distance))
    assert live.table.equals(recorded.table) and live.table.equals(log.table)
    assert np.array_equal(live.distances, log.distances)
    assert (log.settings.length, log.settings.world) == (10, live.settings.world)


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    recorder = Recorder(Corridor(wall=1), clock=iter(np.arange(0, 1e4, 0.1)).__next__)
    measure(recorder, n=4, length=6, protocol="return")
    return write_log(tmp_path_factory.mktemp("log") / "log.parquet", recorder)


def rewrite(log, target, change, **described):
    """The log after `change` of its frame; with `described` in place of its metadata."""
    frame = change(pq.read_table(log).to_pandas())
    table = pa.Table.from_pandas(frame, preserve_index=False)
    pq.write_table(table.replace_schema_metadata({"log": json.dumps(described)}), target)
    return target


def test_columns_that_are_optional_may_be_missing(log, tmp_path) -> None:
    whole = measure_log(log)
    bare = rewrite(
        log, tmp_path / "bare.parquet", lambda f: f[f["episode"] >= 0].drop(columns=["leg", "dof"])
    )
    found = measure_log(bare)
    assert found.names == ("action-0", "action-1") and found.settings.world == "bare"
    assert np.array_equal(found.distances, whole.distances)
    scaled = measure_log(bare, distance="scaled")
    assert scaled.thresholds == (0.1, 0.01) and (scaled.distances[:, 1] == 0).all()
    own = measure_log(bare, distance=lambda a, b: float(np.abs(a - b).max()), thresholds=0.5)
    assert own.thresholds == (0.5,)


def test_degrees_of_freedom_may_be_tried_unequally_often(log, tmp_path) -> None:
    found = measure_log(
        rewrite(log, tmp_path / "few.parquet", lambda f: f[f["episode"] != 7], dofs=["a", "b"])
    )
    assert found.table["n"].tolist() == [4, 3] and np.isnan(found.distances[3, 1])
    assert found.order().table["n"].tolist() == [3, 3]
    loaded = Measurement.load(found.save(tmp_path / "scp.parquet"))
    assert loaded.table.equals(found.table)


def change_action(frame: pd.DataFrame) -> pd.DataFrame:
    row = frame.index[(frame["episode"] == 2) & (frame["leg"] == 2)][0]
    frame.at[row, "action"] = frame.at[row, "action"] * 0.5
    return frame


@pytest.mark.parametrize(
    ("change", "described", "message"),
    [
        (change_action, {}, "episode 2 is no trial: leg 2 is not the inverse of leg 1"),
        (lambda f: f[f["leg"] != 3], {}, "episode 0 lacks steps or has them out of order"),
        (lambda f: f[(f["episode"] != 1) | (f["leg"] < 4)], {}, "episode 1 has 3 legs"),
        (lambda f: f[f["episode"] < 0], {}, "has no trial"),
        (lambda f: f[:0], {}, "has no rows"),
        (lambda f: f.drop(columns="action"), {}, "has no column action"),
        (lambda f: f, dict(dofs=["a"]), "names 1 degrees of freedom, but actions have 2"),
        (lambda f: f, dict(shape=[2, 2]), "which is not the shape"),
        (lambda f: f.assign(observation=[np.zeros(1 + i % 2) for i in range(len(f))]), {},
         "column observation have different lengths"),
        (lambda f: f.assign(observation=[np.full(3, np.nan)] * len(f)), {}, "no finite numbers"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_log_is_said_in_one_line(
    log, tmp_path, change, described, message
) -> None:
    file = rewrite(log, tmp_path / "log.parquet", change, **described)
    with pytest.raises(TableError, match=message) as raised:
        measure_log(file)
    assert "\n" not in str(raised.value) and "log.parquet" in str(raised.value)


def test_what_is_no_log_is_refused(tmp_path) -> None:
    with pytest.raises(TableError, match="there is no such log"):
        measure_log(tmp_path / "none.parquet")
    (tmp_path / "text.parquet").write_text("no table")
    with pytest.raises(TableError, match="not a readable Parquet file"):
        measure_log(tmp_path / "text.parquet")
    with pytest.raises(UserError, match="nothing was recorded"):
        write_log(tmp_path / "log.parquet", Recorder(Corridor()))
