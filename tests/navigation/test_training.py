"""Training runs: their learner, their curve, and runs that are killed at any moment."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
import torch

from sensory_commutativity.navigation import training
from sensory_commutativity.navigation.evaluation import evaluate
from sensory_commutativity.navigation.learner import ViewFeatures
from sensory_commutativity.navigation.recurrent import WholeRolloutPPO
from sensory_commutativity.navigation.sb3 import Sb3VecEnv
from sensory_commutativity.navigation.settings import LearnerSettings, TrainingRun
from sensory_commutativity.navigation.training import (
    learner_of_run,
    make_scaled_rooms,
    policy_of_run,
    train,
)
from sensory_commutativity.storage import checkpoints
from sensory_commutativity.storage.checkpoints import Checkpoint, CheckpointError
from tests.navigation.small import LEARNER, SCALES, TASK

RUN = TrainingRun(
    task=TASK,
    action_space="full",
    seed=0,
    scales=SCALES,
    learner=LEARNER,
    steps=192,  # three segments of one rollout
    checkpoints=3,
    evaluation_seeds=(101, 102, 103, 104),
    root_seed=7,
    settings="some settings",
)


@pytest.fixture(autouse=True)
def one_thread():
    torch.set_num_threads(1)


class Killed(BaseException):
    """Not an Exception, so that nothing catches it."""


def train_in(folder, run: TrainingRun = RUN):
    return train(run, Checkpoint(folder / "run.parquet", "settings"))


def equal(a, b) -> bool:
    """Whether two results of `train` have the same curve and weights."""
    weights = zip(a[1]["policy"].items(), b[1]["policy"].items(), strict=True)
    return a[0].equals(b[0]) and all(n == m and torch.equal(x, y) for (n, x), (m, y) in weights)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    torch.set_num_threads(1)
    return train_in(tmp_path_factory.mktemp("trained"))


# ---- learner -------------------------------------------------------------------------------------


def test_the_learner_uses_all_its_settings():
    settings = LearnerSettings(
        rooms=4, rollout_steps=16, batch_size=16, epochs=3, learning_rate=2e-3, discount=0.9,
        gae_lambda=0.8, clip_range=0.3, entropy_coefficient=0.01, value_coefficient=0.7,
        max_gradient_norm=0.4, features=5, memory=6, initial_log_std=-1.0, reward_scale=0.5,
    )  # fmt: skip
    for field in fields(settings):
        if field.name not in ("rooms", "rollout_steps"):
            assert getattr(settings, field.name) != getattr(LearnerSettings(), field.name)
    learner = learner_of_run(replace(RUN, learner=settings))
    policy, buffer = learner.policy, learner.rollout_buffer
    assert (learner.n_envs, learner.n_steps, learner.batch_size, learner.n_epochs) == (4, 16, 16, 3)
    assert (learner.gamma, learner.gae_lambda) == (buffer.gamma, buffer.gae_lambda) == (0.9, 0.8)
    assert (learner.ent_coef, learner.vf_coef, learner.max_grad_norm) == (0.01, 0.7, 0.4)
    assert learner.clip_range(1.0) == learner.clip_range(0.1) == 0.3
    assert learner.lr_schedule(1.0) == learner.lr_schedule(0.1) == 2e-3
    assert (policy.lstm_actor.input_size, policy.lstm_actor.hidden_size) == (5, 6)
    assert policy.lstm_critic is None and policy.log_std.tolist() == [-1.0] * 4
    assert learner.env.reward_scale == 0.5


def test_settings_that_do_not_fit_together_are_rejected():
    for size in (24, 48, 128):
        with pytest.raises(ValueError, match=f"batch_size {size} must be rollout_steps 16 times"):
            replace(LEARNER, batch_size=size)
    with pytest.raises(ValueError, match="steps 200 must be a multiple"):
        replace(RUN, steps=200)


def test_features_depend_on_every_pixel_and_colour():
    torch.manual_seed(0)
    features = ViewFeatures(TASK.make_env().observation_space, 9)
    view = torch.full((2, 64, 3), 128.0, requires_grad=True)
    assert features(view).shape == (2, 9)
    output = features.network[0](view.transpose(1, 2) / 255).sum()
    gradient = torch.autograd.grad(output, view)[0][0].abs()
    assert (gradient.sum(dim=0) > 0).all() and (gradient.sum(dim=1) > 0).all()
    integers = torch.randint(0, 256, (1, 64, 3), dtype=torch.uint8)
    assert torch.equal(features(integers), features(integers.float()))


def test_initial_weights_depend_on_action_space_seed_and_root_seed():
    def weights(**changes) -> torch.Tensor:
        return learner_of_run(replace(RUN, **changes)).policy.action_net.weight

    reference = weights()
    assert torch.equal(weights(), reference)
    for changes in ({"seed": 1}, {"action_space": "adapted"}, {"root_seed": 8}):
        assert not torch.equal(weights(**changes), reference), changes


# ---- runs ----------------------------------------------------------------------------------------


def test_the_curve_holds_the_results_of_the_evaluations(trained, tmp_path, monkeypatch):
    curve, results = trained[0], []

    def record(policy, rooms, seeds):
        results.append((evaluate(policy, rooms, seeds), seeds))
        return results[-1][0]

    monkeypatch.setattr(training, "evaluate", record)
    assert equal(train_in(tmp_path), trained)
    assert curve["step"].tolist() == [64, 128, 192] and (curve["episodes"] == 4).all()
    for (episodes, seeds), row in zip(results, curve.itertuples(), strict=True):
        assert seeds == RUN.evaluation_seeds
        assert row.episode_return == episodes.returns.mean()
        assert row.episode_length == episodes.lengths.mean()
        assert (row.success_rate, row.dead_rate) == (episodes.success_rate, episodes.dead_rate)


def test_random_numbers_of_the_process_do_not_matter(trained, tmp_path):
    np.random.seed(5)  # noqa: NPY002  (Stable-Baselines3 draws from it)
    torch.manual_seed(5)
    learner_of_run(RUN).learn(64)
    assert equal(train_in(tmp_path), trained)


def test_every_segment_of_every_run_has_rooms_of_its_own(trained, tmp_path, monkeypatch):
    seeds, results = [], []
    seed = Sb3VecEnv.seed

    def record(self, value=None):
        seeds.append(value)
        return seed(self, value)

    monkeypatch.setattr(Sb3VecEnv, "seed", record)
    for i, changes in enumerate([{}, {"seed": 1}, {"action_space": "truncated"}]):
        (tmp_path / str(i)).mkdir()
        results.append(train_in(tmp_path / str(i), replace(RUN, **changes)))
    assert [equal(result, trained) for result in results] == [True, False, False]
    assert len(seeds) == len(set(seeds)) == 3 * (1 + 3)  # at creation, and for every segment
    env = learner_of_run(RUN).env
    rooms = [room for value in seeds[:12] for room in seed(env, value)]
    assert len(set(rooms)) == len(rooms) == 4 * 12


def test_a_restored_policy_plays_like_the_learner(trained):
    curve, model = trained
    assert (model["action_space"], model["seed"], model["scales"]) == ("full", 0, SCALES)
    policy = policy_of_run(model, TASK, LEARNER, "some settings", "model")
    rooms = make_scaled_rooms(TASK, 4, model["scales"])
    episodes = evaluate(policy, rooms, RUN.evaluation_seeds)
    assert episodes.returns.mean() == curve["episode_return"].iloc[-1]
    assert episodes.lengths.mean() == curve["episode_length"].iloc[-1]
    with pytest.raises(CheckpointError, match=r"full\.0\.policy: .*other settings"):
        policy_of_run(model, TASK, LEARNER, "other settings", "full.0.policy")
    with pytest.raises(CheckpointError, match=r"full\.0\.policy: no trained policy"):
        policy_of_run({"policy": {}}, TASK, LEARNER, "some settings", "full.0.policy")


# ---- killed runs ---------------------------------------------------------------------------------


def kill_at_call(function, n: int):
    """`function`, but its n-th call raises Killed."""
    calls = []

    def call(*args, **kwargs):
        calls.append(1)
        if len(calls) == n:
            raise Killed
        return function(*args, **kwargs)

    return call


def count_segments(monkeypatch) -> list[int]:
    """The returned list gets the steps of every segment that is trained from now on."""
    segments: list[int] = []
    learn = WholeRolloutPPO.learn

    def record(self, steps):
        segments.append(steps)
        return learn(self, steps)

    monkeypatch.setattr(WholeRolloutPPO, "learn", record)
    return segments


@pytest.mark.parametrize(
    "place",
    [
        (WholeRolloutPPO, "train"),
        (training, "evaluate"),
        (Checkpoint, "save"),
        (checkpoints.torch, "save"),
    ],
    ids=["update", "evaluation", "before-saving", "while-saving"],
)
def test_a_killed_run_resumes_and_ends_as_if_it_had_not_been_killed(
    place, trained, tmp_path, monkeypatch
):
    for n in (1, 2, 3):
        folder = tmp_path / str(n)
        folder.mkdir()
        with monkeypatch.context() as patch:
            patch.setattr(*place, kill_at_call(getattr(*place), n))
            with pytest.raises(Killed):
                train_in(folder)
        np.random.seed(n)  # noqa: NPY002  (as if in another process)
        torch.manual_seed(n)
        with monkeypatch.context() as patch:
            segments = count_segments(patch)
            assert equal(train_in(folder), trained), n
        assert segments == [64] * (4 - n), n  # saved segments are not trained again


def test_a_run_that_is_killed_repeatedly_gets_to_its_end(trained, tmp_path, monkeypatch):
    for _ in range(2):  # each attempt completes one segment
        with monkeypatch.context() as patch:
            patch.setattr(WholeRolloutPPO, "train", kill_at_call(WholeRolloutPPO.train, 2))
            with pytest.raises(Killed):
                train_in(tmp_path)
    assert len(Checkpoint(tmp_path / "run.parquet", "settings").load()["curve"]) == 2
    assert equal(train_in(tmp_path), trained)
    with monkeypatch.context() as patch:
        segments = count_segments(patch)
        assert equal(train_in(tmp_path), trained)
    assert segments == []  # a finished run is not trained again
