"""From SC-experiments to SCP, hierarchy, stability of the order, and touch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from sensory_commutativity.errors import TableError
from sensory_commutativity.scp.world import Dof
from sensory_commutativity.storage.tables import read_metadata
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.apartment.tables import apartment_experiments as module
from sensory_commutativity.studies.apartment.tables.apartment_experiments import (
    apartment_experiments,
)
from sensory_commutativity.studies.apartment.tables.apartment_hierarchy import (
    apartment_hierarchy,
    compare_groups,
)
from sensory_commutativity.studies.apartment.tables.apartment_interaction import (
    apartment_interaction,
)
from sensory_commutativity.studies.apartment.tables.apartment_order import apartment_order
from sensory_commutativity.studies.apartment.tables.apartment_scp import apartment_scp
from sensory_commutativity.worlds.apartment.world import PrivilegedInfo
from tests.studies.apartment.examples import N, with_experiments


def check(frame: pd.DataFrame, table, config) -> None:
    """Rows have unique keys, all are there, and without one of them they are refused."""
    assert not frame.duplicated(table.key).any()
    runner.check_complete(frame, table, config, Path("table"))
    with pytest.raises(TableError, match=r"incomplete|missing"):
        runner.check_complete(frame[1:], table, config, Path("table"))


def test_the_scp_is_counted_at_every_threshold(experiments, config, scp):
    check(experiments, apartment_experiments, config)
    table = apartment_scp(experiments, config)
    check(table, apartment_scp, config)
    fetch = table[table["robot"] == "fetch"]
    assert (fetch.loc[fetch["threshold"] == 0, "scp"] == 0).all()
    for row in fetch[fetch["threshold"] == 50].itertuples():
        expected = 1.0 if row.apartment == "free-space" else scp["fetch"][row.dof]
        assert row.n == N and row.scp == pytest.approx(expected, abs=1 / N)
        assert row.ci_low <= row.scp <= row.ci_high


def test_steps_of_the_hierarchy_by_hand():
    distances = {"a": [900, 900, 900, 5], "b": [900, 5, 900, 5], "c": [5, 5, 5, 900]}
    rows = [(dof, i, float(d)) for dof, values in distances.items() for i, d in enumerate(values)]
    frame = pd.DataFrame(rows, columns=["dof", "experiment", "distance"])
    (row,) = compare_groups(frame, {"low": ["a", "b"], "high": ["c"]}, 50).itertuples()
    expected = np.array([0 - 1, 0.5 - 1, 0 - 1, 1 - 0])
    assert (row.lower, row.higher, row.n) == ("low", "high", 4)
    assert (row.scp_lower, row.scp_higher) == pytest.approx((3 / 8, 3 / 4))
    assert row.difference == pytest.approx(expected.mean())
    assert row.p == row.p_adjusted == pytest.approx(stats.ttest_1samp(expected, 0).pvalue)
    assert row.ci_low < row.difference < row.ci_high


def test_the_hierarchy_holds_the_steps_of_both_robots(experiments, config):
    table = apartment_hierarchy(experiments, config)
    check(table, apartment_hierarchy, config)
    chosen = (table["robot"] == "fetch") & (table["apartment"] == "rs-stand-in")
    chosen &= (table["start"] == "anywhere") & (table["length"] == 50)
    steps = table[chosen & (table["threshold"] == 50) & (table["field_of_view"] == 90)]
    groups = ["wheel", "shoulder", "elbow", "wrist"]
    assert steps["lower"].tolist() == groups[:-1] and steps["higher"].tolist() == groups[1:]
    assert (steps["difference"] < 0).all() and (steps["p_adjusted"] >= steps["p"]).all()
    assert set(table["robot"]) == {"fetch", "jackrabbot"}


def test_the_same_order_has_tau_1_under_every_change(order, config):
    check(order, apartment_order, config)
    assert order.groupby("changed").size().to_dict() == {
        "threshold": 5, "field of view": 1, "apartment": 2, "start": 1, "length": 2
    }  # fmt: skip
    tau = order.set_index("value")["tau"]
    assert tau[["20", "100", "200"]].tolist() == pytest.approx([1, 1, 1])
    assert np.isnan(tau["0"])  # nothing commutes at 0: there is no order
    assert (order.loc[order["changed"] != "threshold", "tau"] > 0.99).all()
    assert (order["n"] == N).all()


def test_experiments_are_touched_hindered_or_free(experiments, config):
    touched = experiments["experiment"] < N // 2
    even = experiments["experiment"] % 2 == 0
    frame = experiments.assign(touched_fixed=touched * 2, at_limit=even * 1)
    table = apartment_interaction(frame, config)
    check(table, apartment_interaction, config)
    assert (table["touched"] == 0.5).all() and (table["n_touched"] == N // 2).all()
    assert (table["n_hindered"] == N // 4).all() and (table["n_free"] == N // 4).all()
    commuted = table[["commuted_touched", "commuted_hindered", "commuted_free"]].sum(axis=1)
    assert (commuted == (table["scp"] * N).round()).all()


class Turntable:
    """A world of one degree of freedom whose two cameras show the largest angle so far."""

    dofs = (Dof("turn", "rad", 1.0),)

    def reset(self, rng: np.random.Generator) -> None:
        self.angle = self.largest = float(rng.uniform())

    def snapshot(self) -> float:
        return self.angle

    def restore(self, snapshot: float) -> None:
        self.angle = self.largest = snapshot

    def step(self, action: np.ndarray) -> None:
        self.angle += float(action[0])
        self.largest = max(self.largest, self.angle)

    def observe(self) -> np.ndarray:
        image = np.full((4, 4, 3), 20 * self.largest, np.uint8)
        return np.stack([image, image // 2])

    def happened(self) -> PrivilegedInfo:
        base, joints = np.array([3.0, 4.0, 7.0]) * self.largest, np.array([self.angle])
        steps = int(10 * self.largest)
        return PrivilegedInfo(steps, 0, 1, 2, np.array([self.largest]), base, joints, 0.5)


class MeanColour:
    """Distance of the mean colours of two images."""

    def __init__(self, weights: str = "made up"):
        self.metadata = {"vgg16_sha256": weights}

    def distances(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return (first.mean((1, 2, 3)) - second.mean((1, 2, 3))) ** 2


@pytest.fixture
def turntable(default_config, monkeypatch):
    """A configuration whose reference run has two shards of six and five experiments, played in
    Turntable, and how many experiments were played."""
    played = []

    def endings_per_dof(world, seed, *args):
        played.append(seed)
        return original(world, seed, *args)

    original = module.endings_per_dof
    monkeypatch.setattr(module, "endings_per_dof", endings_per_dof)
    monkeypatch.setattr(module, "build_run_world", lambda config, run: Turntable())
    monkeypatch.setattr(module, "perceptual_features", lambda config: MeanColour())
    monkeypatch.setattr(module, "count_dofs", lambda settings: {"fetch": 1})
    return with_experiments(default_config, 11, experiments_per_job=6), played


RUN = "fetch.rs-stand-in.anywhere.50"


def write_shard(config, name: str, path: Path) -> pd.DataFrame:
    shard = apartment_experiments.shards.find(config, name)
    runner.write_product(apartment_experiments, config, [], path, shard)
    return runner.read_shards(apartment_experiments, config, [path])[0]


def test_a_killed_shard_resumes_and_shards_must_share_their_weights(
    turntable, tmp_path, monkeypatch
):
    config, played = turntable
    names = [shard.name for shard in apartment_experiments.shards.of_run(config, RUN)]
    assert names == [f"{RUN}.1-of-2", f"{RUN}.2-of-2"]
    paths = [tmp_path / f"{name}.parquet" for name in names]
    whole = apartment_experiments(config, RUN).compute(0, 11)
    assert whole["field_of_view"].tolist() == [90.0, 45.0] * 11
    distances = whole["distance"].to_numpy().reshape(11, 2)  # that of the second camera is smaller
    assert (distances[:, 0] >= distances[:, 1]).all() and (distances[:, 0] > 0).sum() > 5

    def kill(*args):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        calls = iter([MeanColour.distances, kill])  # the second batch is killed
        patch.setattr(MeanColour, "distances", lambda *args: next(calls)(*args))
        with pytest.raises(KeyboardInterrupt):
            write_shard(config, names[0], paths[0])
    played.clear()
    frames = [write_shard(config, name, path) for name, path in zip(names, paths, strict=True)]
    assert len(played) == 1 + 5  # the batch of five that was finished is not played again
    assert pd.concat(frames, ignore_index=True).equals(whole)
    assert read_metadata(paths[0])["vgg16_sha256"] == "made up"
    monkeypatch.setattr(module, "perceptual_features", lambda config: MeanColour("other"))
    write_shard(config, names[1], paths[1])
    with pytest.raises(TableError, match=r"2-of-2\.parquet: its vgg16_sha256 differ"):
        runner.read_shards(apartment_experiments, config, paths)
    other = with_experiments(config, 11, experiments_per_job=6, rest_steps=4)
    with pytest.raises(TableError, match="other settings"):
        runner.read_shards(apartment_experiments, other, paths[:1])


def test_events_are_those_of_the_order_with_more_of_them():
    a, b = Turntable(), Turntable()
    a.angle, a.largest, b.angle, b.largest = 0.5, 1.0, -0.5, 2.0
    events = module._events(a.happened(), b.happened())
    names = apartment_experiments.column_names
    row = dict(zip(names[names.index("touched_fixed") :], events, strict=False))
    assert row == pytest.approx(
        dict(touched_fixed=20, touched_movable=0, touched_self=1, at_limit=2, object_shift=2.0,
             base_difference=5.0, turn_difference=7 - 2 * np.pi, joint_difference=1.0,
             clearance=0.5)
    )  # fmt: skip
