"""One update against Stable-Baselines3's own, and runs that are killed at any moment."""

from __future__ import annotations

import copy

import numpy as np
import pandas as pd
import pytest
import torch
from sb3_contrib import RecurrentPPO
from sb3_contrib.common.recurrent.buffers import RecurrentRolloutBuffer
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from sensory_commutativity.helpers import DEFAULT, DOFS, ROOT
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger

from sensory_commutativity.navigation import training
from sensory_commutativity.navigation.learner import RoomPPO, ViewFeatures
from sensory_commutativity.navigation.rooms import Rooms
from sensory_commutativity.navigation.training import (
    learner_of_run,
    policy_of_run,
    settings_of_run,
    train,
)
from sensory_commutativity.storage import checkpoints
from sensory_commutativity.storage.checkpoints import (
    Checkpoint,
    CheckpointError,
    load_state,
    save_state,
)
from sensory_commutativity.storage.tables import read_table, write_table
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load, merge, validate
from sensory_commutativity.studies.navigation.builders import evaluation_seeds
from sensory_commutativity.studies.navigation.tables import navigation_curves
from sensory_commutativity.studies.navigation.tables.navigation_curves import write_run

SCALES = dict(zip(DOFS, [1.0, 0.5, 0.0, 0.0, 0.25, 0.0, 0.0, 0.1], strict=True))


def with_navigation(config: Config, **changes) -> Config:
    return validate(merge(config.model_dump(mode="json"), {"navigation": changes}))


@pytest.fixture(scope="module")
def config() -> Config:
    """Three segments of one rollout each."""
    return with_navigation(
        load(DEFAULT, ROOT / "config" / "test.yaml"), steps=192, checkpoints=3, max_episode_steps=11
    )


@pytest.fixture(autouse=True)
def one_thread():
    torch.set_num_threads(1)


class Killed(BaseException):
    """Not an Exception: nothing catches it, like a signal."""


# ---- an update -------------------------------------------------------------------------------------------------------------


class _Go(BaseCallback):
    def _on_step(self) -> bool:
        return True


@pytest.fixture(scope="module")
def rolled_out(config) -> RoomPPO:
    """A learner that has rolled out before, so that the rollout begins in the middle of episodes."""
    torch.set_num_threads(1)
    learner = learner_of_run(config, "full", 0, dict.fromkeys(DOFS, 1.0))
    learner.env.seed(1)
    _, callback = learner._setup_learn(10_000, _Go())
    for _ in range(3):
        learner.collect_rollouts(learner.env, callback, learner.rollout_buffer, learner.n_steps)
    return learner


def theirs(learner: RoomPPO) -> RecurrentPPO:
    """sb3-contrib's own algorithm, policy and buffer, with the same weights, rollout and settings."""
    other = RecurrentPPO(
        RecurrentActorCriticPolicy, learner.env, n_steps=learner.n_steps, batch_size=learner.n_steps * learner.n_envs, n_epochs=1,
        learning_rate=learner.learning_rate, ent_coef=learner.ent_coef, vf_coef=learner.vf_coef, max_grad_norm=learner.max_grad_norm,
        clip_range=learner.clip_range(1.0), gamma=learner.gamma, gae_lambda=learner.gae_lambda, policy_kwargs=learner.policy_kwargs, device="cpu",
    )  # fmt: skip
    other.policy.load_state_dict(learner.policy.state_dict())
    assert (
        type(other.rollout_buffer) is RecurrentRolloutBuffer
        and type(other.policy) is RecurrentActorCriticPolicy
    )
    for name, value in vars(learner.rollout_buffer).items():
        if isinstance(value, np.ndarray):
            setattr(other.rollout_buffer, name, value.copy())
    other.rollout_buffer.full = True
    other.set_logger(Logger(folder=None, output_formats=[]))
    return other


@pytest.mark.parametrize("drift", [0.0, 0.3])
def test_an_update_has_the_loss_and_the_gradients_of_sb3_contribs_own(
    rolled_out, drift, monkeypatch
):
    """With weights that have moved since the rollout, so that ratios are not 1 and some are clipped."""
    learner = rolled_out
    buffer, kept = learner.rollout_buffer, copy.deepcopy(learner.policy.state_dict())
    assert buffer.episode_starts[1:].sum() >= 4 and np.abs(buffer.hidden_states_pi[0]).max() > 0
    with torch.no_grad():
        torch.manual_seed(0)
        for weight in learner.policy.parameters():
            weight.add_(drift * weight.abs().mean() * torch.randn_like(weight))
    other = theirs(learner)
    learner.batch_size, learner.n_epochs = learner.n_steps * learner.n_envs, 1
    monkeypatch.setattr(
        np.random, "randint", lambda n: 0
    )  # sb3-contrib cuts a room's rollout somewhere; not here
    for algorithm in (learner, other):
        algorithm.train()
    logs = [
        {
            key: value
            for key, value in one.logger.name_to_value.items()
            if key not in ("train/n_updates", "train/std")
        }
        for one in (learner, other)
    ]
    assert logs[0] == pytest.approx(logs[1], rel=1e-4, abs=1e-5)
    assert drift == 0 or logs[0]["train/clip_fraction"] > 0.05
    for (name, a), (_, b) in zip(
        learner.policy.named_parameters(), other.policy.named_parameters(), strict=True
    ):
        assert (a.grad is None) == (b.grad is None), name
        if a.grad is not None:
            assert torch.allclose(
                a.grad, b.grad, rtol=1e-3, atol=1e-4 * float(b.grad.abs().max()) + 1e-8
            ), name
    learner.policy.load_state_dict(kept)


def test_the_learner_has_the_settings_of_the_configuration(config):
    settings = dict(
        learning_rate=2e-3, discount=0.9, gae_lambda=0.8, clip_range=0.3, entropy_coefficient=0.01, value_coefficient=0.7,
        max_gradient_norm=0.4, features=5, memory=6, initial_log_std=-1.0, epochs=3, batch_size=16, reward_scale=0.5,
    )  # fmt: skip
    learner = learner_of_run(with_navigation(config, learner=settings), "truncated", 1, SCALES)
    assert (learner.gamma, learner.gae_lambda, learner.ent_coef, learner.vf_coef) == (
        0.9,
        0.8,
        0.01,
        0.7,
    )
    assert (learner.rollout_buffer.gamma, learner.rollout_buffer.gae_lambda) == (0.9, 0.8)
    assert (
        learner.max_grad_norm,
        learner.n_epochs,
        learner.batch_size,
        learner.n_steps,
        learner.n_envs,
    ) == (0.4, 3, 16, 16, 4)
    assert (
        learner.clip_range(1.0) == learner.clip_range(0.1) == 0.3
        and learner.lr_schedule(1.0) == learner.lr_schedule(0.1) == 2e-3
    )
    assert (
        learner.policy.lstm_actor.hidden_size == 6
        and learner.policy.lstm_actor.input_size == 5
        and learner.policy.lstm_critic is None
    )
    assert learner.policy.log_std.tolist() == [-1.0] * 4 and learner.env.reward_scale == 0.5


def test_the_features_see_the_view_and_all_colours(config):
    learner = learner_of_run(config, "full", 0, SCALES)
    features = ViewFeatures(learner.observation_space, 9)
    view = torch.full((2, 64, 3), 128.0, requires_grad=True)
    found = features(view)
    assert found.shape == (2, 9)
    used = torch.autograd.grad(features.network[0](view.transpose(1, 2) / 255).sum(), view)[0][0]
    assert (used.abs().sum(dim=0) > 0).all() and (used.abs().sum(dim=1) > 0).all()
    assert torch.equal(
        features(torch.zeros(1, 64, 3, dtype=torch.uint8)), features(torch.zeros(1, 64, 3))
    )


def test_the_weights_of_a_run_follow_from_its_name(config):
    def weights(action_space: str, seed: int) -> torch.Tensor:
        return learner_of_run(config, action_space, seed, SCALES).policy.action_net.weight

    assert torch.equal(weights("full", 3), weights("full", 3))
    assert not torch.equal(weights("full", 3), weights("full", 4)) and not torch.equal(
        weights("full", 3), weights("adapted", 3)
    )


# ---- runs ------------------------------------------------------------------------------------------------------------------


def run(config, folder, seed=0, action_space="full", scales=SCALES):
    return train(config, action_space, seed, scales, Checkpoint(folder / "run.parquet", "settings"))


def same(a, b) -> bool:
    weights = zip(a[1]["policy"].items(), b[1]["policy"].items(), strict=True)
    return a[0].equals(b[0]) and all(n == m and torch.equal(x, y) for (n, x), (m, y) in weights)


@pytest.fixture(scope="module")
def whole(config, tmp_path_factory):
    return run(config, tmp_path_factory.mktemp("whole"))


def dies_at(original, n: int):
    """`original`, which is killed when it is called for the n-th time."""
    calls = []

    def call(*args, **kwargs):
        calls.append(1)
        if len(calls) == n:
            raise Killed
        return original(*args, **kwargs)

    return call


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize(
    "where",
    [(RoomPPO, "train"), (training, "evaluate"), (Checkpoint, "save"), (checkpoints.torch, "save")],
    ids=["update", "evaluation", "before-saving", "while-saving"],
)
def test_a_run_that_is_killed_anywhere_ends_as_if_it_had_not_been(
    where, n, config, whole, tmp_path, monkeypatch
):
    with monkeypatch.context() as patch:
        patch.setattr(*where, dies_at(getattr(*where), n))
        with pytest.raises(Killed):
            run(config, tmp_path)
    np.random.seed(n)  # noqa: NPY002  (another process, another state of what Stable-Baselines3 draws from)
    torch.manual_seed(n)
    segments = []
    learn = RoomPPO.learn
    monkeypatch.setattr(
        RoomPPO, "learn", lambda self, steps: (segments.append(steps), learn(self, steps))[1]
    )
    assert same(run(config, tmp_path), whole)
    assert segments == [64] * (4 - n)  # what was saved is not done again


def test_a_run_that_is_killed_again_and_again_gets_there(config, whole, tmp_path, monkeypatch):
    for _ in range(2):  # each gets one segment further
        with monkeypatch.context() as patch:
            patch.setattr(RoomPPO, "train", dies_at(RoomPPO.train, 2))
            with pytest.raises(Killed):
                run(config, tmp_path)
    assert len(Checkpoint(tmp_path / "run.parquet", "settings").load()["curve"]) == 2
    assert same(run(config, tmp_path), whole)


def test_a_finished_run_is_not_trained_again(config, whole, tmp_path, monkeypatch):
    run(config, tmp_path)
    monkeypatch.setattr(RoomPPO, "learn", dies_at(None, 1))
    assert same(run(config, tmp_path), whole)


def test_the_curve_is_what_the_evaluations_gave(config, whole, tmp_path, monkeypatch):
    curve, seen = whole[0], []
    assert curve.columns.tolist() == [
        "step",
        "episode_return",
        "success_rate",
        "dead_rate",
        "episode_length",
        "episodes",
    ]
    assert (
        curve["step"].tolist() == [64, 128, 192]
        and (curve["episodes"] == 4).all()
        and curve["episode_length"].between(1, 11).all()
    )
    evaluate = training.evaluate
    monkeypatch.setattr(
        training,
        "evaluate",
        lambda *args: (seen.append((evaluate(*args), args[2])), seen[-1][0])[1],
    )
    assert same(run(config, tmp_path), whole)
    for (episodes, seeds), row in zip(seen, curve.itertuples(), strict=True):
        assert seeds == evaluation_seeds(config) and len(set(seeds)) == 4
        assert (row.episode_return, row.episode_length) == (
            episodes.returns.mean(),
            episodes.lengths.mean(),
        )
        assert (row.success_rate, row.dead_rate) == (episodes.success_rate, episodes.dead_rate)


def test_every_segment_of_every_run_has_rooms_of_its_own(config, tmp_path, monkeypatch):
    seeds = []
    seed = Rooms.seed
    monkeypatch.setattr(
        Rooms, "seed", lambda self, value=None: (seeds.append(value), seed(self, value))[1]
    )
    for i, (action_space, number) in enumerate([("full", 0), ("full", 1), ("truncated", 0)]):
        (tmp_path / str(i)).mkdir()
        run(config, tmp_path / str(i), number, action_space)
    assert len(seeds) == len(set(seeds)) == 3 * (3 + 1)  # and the one that the learner is made with
    environment = learner_of_run(config, "full", 0, SCALES).env
    rooms = [room for value in seeds[:12] for room in seed(environment, value)]
    assert len(set(rooms)) == len(rooms) == 4 * 12


def test_the_state_of_the_process_does_not_matter(config, whole, tmp_path):
    np.random.seed(5)  # noqa: NPY002  (what Stable-Baselines3 draws from)
    torch.manual_seed(5)
    learner_of_run(config, "full", 0, SCALES).learn(64)
    assert same(run(config, tmp_path), whole)


def test_the_model_holds_what_is_needed_to_play(config, whole):
    model = whole[1]
    assert (model["action_space"], model["seed"], model["scales"]) == ("full", 0, SCALES)
    policy = policy_of_run(config, model, "model")
    assert all(
        torch.equal(policy.state_dict()[name], value) for name, value in model["policy"].items()
    )
    assert policy.action_space.shape == (4,)
    with pytest.raises(CheckpointError, match=r"full\.0\.policy: .*other settings"):
        policy_of_run(with_navigation(config, learner={"memory": 32}), model, "full.0.policy")


def test_the_file_of_a_model_depends_on_the_run_alone_and_damage_is_told(whole, tmp_path):
    for name in ("a.policy", "another-name.policy"):
        save_state(tmp_path / name, whole[1])
    data = (tmp_path / "a.policy").read_bytes()
    assert data == (tmp_path / "another-name.policy").read_bytes()
    (tmp_path / "a.policy").write_bytes(data[:-9] + b"\0" + data[-8:])
    with pytest.raises(
        CheckpointError, match=r"a\.policy: a damaged file; delete it, and run again"
    ):
        load_state(tmp_path / "a.policy", "run again")
    with pytest.raises(CheckpointError, match=r"none\.policy: there is no such file; run again"):
        load_state(tmp_path / "none.policy", "run again")


# ---- files -----------------------------------------------------------------------------------------------------------------


@pytest.fixture
def scp_file(config, tmp_path):
    frame = pd.DataFrame(
        dict(
            world="furnished",
            agent="sprinter",
            length=50,
            dof=DOFS,
            threshold=0.0,
            n=10,
            commuted=5,
            ci_low=0.0,
            ci_high=1.0,
        )
    )
    write_table(
        "navigation_scp",
        frame.assign(scp=np.linspace(0.1, 0.9, 8)),
        tmp_path / "scp.parquet",
        config,
    )
    return tmp_path / "scp.parquet"


def test_a_run_killed_between_its_two_files_writes_both(config, scp_file, tmp_path, monkeypatch):
    out, model = tmp_path / "runs" / "adapted.1.parquet", tmp_path / "models" / "adapted.1.policy"
    with monkeypatch.context() as patch:
        patch.setattr(navigation_curves, "write_table", dies_at(None, 1))
        with pytest.raises(Killed):
            write_run(config, "adapted", 1, scp_file, out, model)
    assert not out.exists() and [path.suffix for path in out.parent.iterdir()] == [".checkpoint"]
    first = load_state(model, "")["policy"]
    with monkeypatch.context() as patch:
        patch.setattr(RoomPPO, "learn", dies_at(None, 1))  # nothing is trained again
        write_run(config, "adapted", 1, scp_file, out, model)
    again = load_state(model, "")["policy"]
    assert all(torch.equal(again[name], first[name]) for name in first) and [
        path.name for path in out.parent.iterdir()
    ] == [out.name]
    assert read_table("navigation_curves", out)[
        ["action_space", "seed", "step"]
    ].values.tolist() == [["adapted", 1, 64 * k] for k in (1, 2, 3)]


def test_a_checkpoint_of_other_settings_is_not_gone_on_with(
    config, scp_file, tmp_path, monkeypatch
):
    out = tmp_path / "runs" / "full.0.parquet"
    for changed, segments in ((config, 2), (with_navigation(config, max_episode_steps=12), 3)):
        calls = []
        with monkeypatch.context() as patch:
            learn = RoomPPO.learn
            patch.setattr(
                RoomPPO,
                "learn",
                lambda self, steps, calls=calls, learn=learn: (
                    calls.append(steps),
                    learn(self, steps),
                )[1],
            )
            if changed is config:
                patch.setattr(RoomPPO, "train", dies_at(RoomPPO.train, 2))
                with pytest.raises(Killed):
                    write_run(changed, "full", 0, scp_file, out, tmp_path / "full.0.policy")
                assert len(list(out.parent.glob(".*.checkpoint"))) == 1
            else:
                write_run(changed, "full", 0, scp_file, out, tmp_path / "full.0.policy")
        assert len(calls) == segments
    assert [path.name for path in out.parent.iterdir()] == [out.name]


def test_a_run_forgets_its_own_checkpoints_only(tmp_path):
    names = ["full.1.parquet", "full.11.parquet", "adapted.1.parquet"]
    for name in names:
        Checkpoint(tmp_path / name, "settings").save({})
    Checkpoint(tmp_path / names[0], "others").save({})
    Checkpoint(tmp_path / names[0], "settings").forget()
    assert [Checkpoint(tmp_path / name, "settings").load() for name in names] == [None, {}, {}]
    assert len(list(tmp_path.iterdir())) == 2
    Checkpoint(tmp_path / names[0], "settings").forget()  # nothing to forget is no error


def test_a_checkpoint_gives_back_exactly_what_was_saved(tmp_path):
    state = {
        "policy": {"w": torch.tensor([0.1, -0.0, float("inf")])},
        "curve": [{"step": 5, "episode_return": 0.1 + 0.2}],
    }
    checkpoint = Checkpoint(tmp_path / "run.parquet", "settings")
    checkpoint.save({"policy": {"w": torch.zeros(3)}, "curve": []})
    checkpoint.save(state)  # the later one counts
    found = checkpoint.load()
    assert found["curve"] == state["curve"] and torch.equal(
        found["policy"]["w"], state["policy"]["w"]
    )
    assert [path.name for path in tmp_path.iterdir()] == [checkpoint.path.name]


def test_a_damaged_checkpoint_names_file_and_remedy_in_one_line(tmp_path):
    checkpoint = Checkpoint(tmp_path / "run.parquet", "settings")
    checkpoint.save({"curve": []})
    checkpoint.path.write_bytes(checkpoint.path.read_bytes()[:-1])
    with pytest.raises(CheckpointError) as told:
        checkpoint.load()
    assert (
        str(checkpoint.path) in str(told.value)
        and "delete it" in str(told.value)
        and "\n" not in str(told.value)
    )


CHANGES = {
    "steps": {"steps": 384},
    "checkpoints": {"checkpoints": 1 + 2, "steps": 192 * 2},
    "zones": {"zones": [{"x": 120.0, "y": 120.0, "radius": 81.0, "reward": 50.0}]},
    "evaluation_episodes": {"evaluation_episodes": 5},
    "learning_rate": {"learner": {"learning_rate": 0.002}},
    "max_episode_steps": {"max_episode_steps": 12},
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_what_a_run_depends_on_makes_it_another(change, config):
    assert settings_of_run(with_navigation(config, **change), SCALES) != settings_of_run(
        config, SCALES
    )


def test_its_world_agent_root_seed_and_scales_make_a_run_another(config):
    settings = config.model_dump(mode="json")
    navigation = config.navigation
    for layer in (
        {"seed": config.seed + 1},
        {"flatland": {"worlds": {navigation.world: {"width": 640.0}}}},
        {"flatland": {"agents": {navigation.agent: {"arm_length": 45.0}}}},
    ):
        assert settings_of_run(validate(merge(settings, layer)), SCALES) != settings_of_run(
            config, SCALES
        )
    assert settings_of_run(config, {**SCALES, "head": 0.001}) != settings_of_run(config, SCALES)


@pytest.mark.parametrize(
    "change",
    [{"seeds": [0, 1, 2, 3, 4]}, {"action_spaces": ["full", "truncated", "adapted"]}, {"threshold_return": 3.0}, {"calibration_splits": 99},
     {"solved_success_rate": 0.5}],
    ids=str,
)  # fmt: skip
def test_what_a_run_does_not_depend_on_leaves_its_checkpoint_good(change, config):
    assert settings_of_run(with_navigation(config, **change), SCALES) == settings_of_run(
        config, SCALES
    )
