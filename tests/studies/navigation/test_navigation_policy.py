"""Training runs of the study: their files, and runs that are killed while they are written."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import torch

from sensory_commutativity.navigation.recurrent import WholeRolloutPPO
from sensory_commutativity.storage.checkpoints import Checkpoint, CheckpointError, load_state
from sensory_commutativity.storage.tables import read_table
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load, merge, validate
from sensory_commutativity.studies.navigation.builders import scales_of_run
from sensory_commutativity.studies.navigation.models.navigation_policy import navigation_policy
from sensory_commutativity.studies.navigation.tables.navigation_action_spaces import (
    navigation_action_spaces,
)
from sensory_commutativity.studies.navigation.tables.navigation_curves import navigation_curves
from tests.helpers import DEFAULT, DOFS, ROOT


def overlay(config: Config, **navigation) -> Config:
    return validate(merge(config.model_dump(mode="json"), {"navigation": navigation}))


@pytest.fixture(scope="module")
def config() -> Config:
    """Three segments of one rollout each."""
    test = load(DEFAULT, ROOT / "config" / "test.yaml")
    return overlay(test, steps=192, checkpoints=3, max_episode_steps=11)


@pytest.fixture
def scp(config) -> pd.DataFrame:
    """A table navigation_scp; the SCPs increase in the order of the actions."""
    navigation = config.navigation
    rows = dict(world=navigation.scp_world, agent=navigation.agent, dof=DOFS, threshold=0.0)
    values = dict(length=config.flatland.sequence_length, scp=np.linspace(0.1, 0.9, len(DOFS)))
    return pd.DataFrame(rows | values)


@pytest.fixture
def files(tmp_path):
    """Files of the policy and the curve of the run truncated.2000."""
    policy = tmp_path / "models" / "truncated.2000.policy"
    curve = tmp_path / "curves" / "truncated.2000.parquet"
    for path in (policy, curve):
        path.parent.mkdir()
    return [policy, curve]


class Killed(BaseException):
    """Not an Exception, so that nothing catches it."""


def kill(*args, **kwargs):
    raise Killed


def count_segments(monkeypatch, last: int = 99) -> list[int]:
    """The returned list gets the steps of every segment trained; the one after `last` is killed."""
    segments: list[int] = []
    learn = WholeRolloutPPO.learn

    def record(self, steps):
        if len(segments) == last:
            raise Killed
        segments.append(steps)
        return learn(self, steps)

    monkeypatch.setattr(WholeRolloutPPO, "learn", record)
    return segments


def train_policy(scp, config, files) -> None:
    run = "truncated.2000"
    output = runner.training_output(navigation_policy, config, run, *files)
    navigation_policy(scp, config, run, output)


def test_a_run_writes_its_policy_and_curve_and_no_other_file(config, scp, files):
    policy, curve = files
    train_policy(scp, config, files)
    assert list(curve.parent.iterdir()) == [curve] and list(policy.parent.iterdir()) == [policy]
    model = load_state(policy, "")
    assert (model["action_space"], model["seed"]) == ("truncated", 2000)
    assert list(model["scales"].values()) == [1.0] * 4 + [0.0] * 4
    rows = read_table(curve, "navigation_curves", navigation_curves.columns)
    assert rows[["action_space", "seed", "step"]].values.tolist() == [
        ["truncated", 2000, 64 * k] for k in (1, 2, 3)
    ]


def test_a_run_killed_between_its_files_writes_both_and_trains_nothing_again(
    config, scp, files, monkeypatch
):
    policy, curve = files
    with monkeypatch.context() as patch:
        patch.setattr(runner, "write_shard", kill)
        with pytest.raises(Killed):
            train_policy(scp, config, files)
    assert [path.suffix for path in curve.parent.iterdir()] == [".checkpoint"]
    weights = load_state(policy, "")["policy"]
    with monkeypatch.context() as patch:
        segments = count_segments(patch)
        train_policy(scp, config, files)
    assert segments == [] and list(curve.parent.iterdir()) == [curve]
    again = load_state(policy, "")["policy"]
    assert all(torch.equal(again[name], weights[name]) for name in weights)


def test_a_checkpoint_of_other_settings_is_not_used(config, scp, files, monkeypatch):
    curve = files[1]
    with monkeypatch.context() as patch:
        count_segments(patch, last=1)
        with pytest.raises(Killed):
            train_policy(scp, config, files)
    assert len(list(curve.parent.glob(".*.checkpoint"))) == 1
    with monkeypatch.context() as patch:
        segments = count_segments(patch)
        train_policy(scp, overlay(config, max_episode_steps=12), files)
    assert len(segments) == 3 and list(curve.parent.iterdir()) == [curve]


def test_a_damaged_checkpoint_stops_the_run_before_it_writes_anything(
    config, scp, files, monkeypatch
):
    policy, curve = files
    with monkeypatch.context() as patch:
        count_segments(patch, last=1)
        with pytest.raises(Killed):
            train_policy(scp, config, files)
    (checkpoint,) = curve.parent.glob(".*.checkpoint")
    checkpoint.write_bytes(b"half")
    with pytest.raises(CheckpointError):
        train_policy(scp, config, files)
    assert not curve.exists() and not policy.exists()
    assert Checkpoint(curve, "other settings").load() is None


def test_the_table_of_action_spaces_holds_the_scales_of_all_runs(config, scp):
    table = navigation_action_spaces(scp, config)
    assert len(table) == len(DOFS) * len(config.navigation.runs)
    values = dict(zip(scp["dof"], scp["scp"], strict=True))
    for (action_space, seed), rows in table.groupby(["action_space", "seed"]):
        scales = scales_of_run(config, values, action_space, seed)
        assert dict(zip(rows["dof"], rows["scale"], strict=True)) == scales
        assert dict(zip(rows["dof"], rows["scp"], strict=True)) == values
