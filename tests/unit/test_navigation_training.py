"""The learner and its runs: the LSTM without padding, evaluation with its state, runs that repeat and resume bit for bit."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import torch
from sb3_contrib.common.recurrent.buffers import RecurrentRolloutBuffer
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from sensory_commutativity.helpers import DEFAULT, DOFS, ROOT
from stable_baselines3.common.callbacks import BaseCallback

from sensory_commutativity.navigation import training
from sensory_commutativity.navigation.action_spaces import ScaledAction
from sensory_commutativity.navigation.evaluation import evaluate
from sensory_commutativity.navigation.recurrent import RoomPolicy
from sensory_commutativity.navigation.training import learner_of_run, policy_of_run, train
from sensory_commutativity.storage.checkpoints import (
    Checkpoint,
    CheckpointError,
    load_state,
    save_state,
)
from sensory_commutativity.storage.tables import read_table, write_table
from sensory_commutativity.studies.loading import load
from sensory_commutativity.studies.navigation.builders import (
    evaluation_seeds,
    measured_scp,
    navigation_environment,
    navigation_rooms,
    scales_of_run,
)
from sensory_commutativity.studies.navigation.tables.navigation_action_spaces import (
    write_action_spaces,
)
from sensory_commutativity.studies.navigation.tables.navigation_curves import write_run

SCALES = dict(zip(DOFS, [1.0, 0.5, 0.0, 0.0, 0.25, 0.0, 0.0, 0.1], strict=True))


@pytest.fixture(scope="module")
def config():
    return load(DEFAULT, ROOT / "config" / "test.yaml")


@pytest.fixture(autouse=True)
def one_thread():
    torch.set_num_threads(1)


# ---- the LSTM --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [1, 2, 7, 64])
@pytest.mark.parametrize("starts", [0.0, 0.05, 0.4, 1.0])
def test_the_lstm_gives_what_sb3_contribs_loop_gives_and_the_same_gradients(steps, starts):
    torch.manual_seed(steps)
    n, lstm = 6, torch.nn.LSTM(5, 7)
    states = (torch.randn(1, n, 7), torch.randn(1, n, 7))
    begins = (torch.rand(n * steps) < starts).float()
    ours, theirs = torch.randn(n * steps, 5, requires_grad=True), None
    theirs = ours.detach().clone().requires_grad_()
    found, after = RoomPolicy._process_sequence(ours, states, begins, lstm)
    expected, after_expected = RecurrentActorCriticPolicy._process_sequence(
        theirs, states, begins, lstm
    )
    assert torch.allclose(found, expected, atol=1e-6)
    if steps == 1:
        assert all(
            torch.allclose(a, b, atol=1e-6) for a, b in zip(after, after_expected, strict=True)
        )
    weights = torch.randn(7)
    mine = torch.autograd.grad((found @ weights).square().sum(), [ours, *lstm.parameters()])
    other = torch.autograd.grad((expected @ weights).square().sum(), [theirs, *lstm.parameters()])
    assert all(torch.allclose(a, b, rtol=1e-4, atol=1e-4) for a, b in zip(mine, other, strict=True))


class _Stop(BaseCallback):
    def _on_step(self) -> bool:
        return True


@pytest.fixture(scope="module")
def rolled_out(config):
    """A learner with a rollout in its buffer in which episodes end, before any update."""
    torch.set_num_threads(1)
    learner = learner_of_run(config, "full", 0, dict.fromkeys(DOFS, 1.0))
    learner.env.seed(3)
    _, callback = learner._setup_learn(10_000, _Stop())
    for _ in range(3):  # the later rollouts begin with states that are not zero
        learner.collect_rollouts(learner.env, callback, learner.rollout_buffer, learner.n_steps)
    assert learner.rollout_buffer.episode_starts[1:].any()
    return learner


def test_minibatches_hold_every_transition_once_room_by_room(rolled_out):
    buffer, steps = rolled_out.rollout_buffer, rolled_out.n_steps
    np.random.seed(0)  # noqa: NPY002  (what Stable-Baselines3 draws from)
    batches = list(buffer.get(2 * steps))
    assert len(batches) == 2 and all(len(batch.returns) == 2 * steps for batch in batches)
    returns = torch.cat([batch.returns for batch in batches]).reshape(4, steps).numpy()
    order = [int(np.flatnonzero((row == buffer.returns.T).all(1))[0]) for row in returns]
    assert sorted(order) == [0, 1, 2, 3]
    actions = torch.cat([batch.actions for batch in batches]).reshape(4, steps, -1).numpy()
    seen = torch.cat([batch.observations for batch in batches]).reshape(4, steps, 64, 3).numpy()
    hidden = torch.cat([batch.lstm_states.pi[0] for batch in batches], 1).numpy()
    for place, room in enumerate(order):
        assert np.array_equal(actions[place], buffer.actions[:, room])
        assert np.array_equal(seen[place], buffer.observations[:, room])
        assert np.array_equal(hidden[:, place], buffer.hidden_states_pi[0][:, room])
    assert np.abs(hidden).max() > 0


def test_the_loss_sees_what_the_policy_did_when_it_played(rolled_out):
    """Before the first update, evaluating the stored actions gives back the stored values and log-probabilities."""
    (batch,) = rolled_out.rollout_buffer.get(None)
    values, log_prob, _ = rolled_out.policy.evaluate_actions(
        batch.observations, batch.actions, batch.lstm_states, batch.episode_starts
    )
    assert torch.allclose(values.flatten(), batch.old_values, atol=1e-5)
    assert torch.allclose(log_prob, batch.old_log_prob, atol=1e-4)


def test_the_loss_terms_are_those_of_sb3_contribs_own_buffer(rolled_out):
    ours = rolled_out.rollout_buffer
    theirs = RecurrentRolloutBuffer(
        ours.buffer_size,
        ours.observation_space,
        ours.action_space,
        ours.hidden_state_shape,
        ours.device,
        ours.gae_lambda,
        ours.gamma,
        ours.n_envs,
    )
    for name, value in vars(ours).items():
        if isinstance(value, np.ndarray):
            setattr(theirs, name, value.copy())
    theirs.full, theirs.generator_ready = True, False
    np.random.seed(1)  # noqa: NPY002  (what Stable-Baselines3 draws from)
    (padded,) = theirs.get(None)
    (whole,) = ours.get(None)
    mask = padded.mask > 0
    assert mask.sum() == len(whole.returns)
    found = rolled_out.policy.evaluate_actions(
        whole.observations, whole.actions, whole.lstm_states, whole.episode_starts
    )
    loop = RecurrentActorCriticPolicy._process_sequence
    policy = rolled_out.policy
    policy._process_sequence = loop
    expected = policy.evaluate_actions(
        padded.observations, padded.actions, padded.lstm_states, padded.episode_starts
    )
    del policy._process_sequence
    for a, b in zip(found[:2], expected[:2], strict=True):
        assert torch.allclose(a.flatten().sort().values, b.flatten()[mask].sort().values, atol=1e-4)


# ---- evaluation ------------------------------------------------------------------------------------------------------------


def by_hand(config, policy, scales, seed, keep_state=True):
    """One episode in a single environment, the LSTM's state passed from step to step."""
    env = ScaledAction(navigation_environment(config), list(scales.values()))
    seen, _ = env.reset(seed=seed)
    state, start, total, length = None, np.ones(1, bool), 0.0, 0
    while True:
        action, state = policy.predict(
            seen[None], state if keep_state else None, start, deterministic=True
        )
        start = np.zeros(1, bool)
        seen, reward, terminated, truncated, _ = env.step(action[0])
        total, length = total + reward, length + 1
        if terminated or truncated:
            return total, length, terminated


def restless(config):
    """A policy whose mean action depends on its memory: output weights blown up."""
    learner = learner_of_run(config, "full", 1, SCALES)
    with torch.no_grad():
        learner.policy.action_net.weight.mul_(300)
    return learner.policy


def test_evaluation_equals_episodes_played_one_by_one(config):
    policy, seeds = restless(config), evaluation_seeds(config)
    rooms = navigation_rooms(config, len(seeds), SCALES)
    found = evaluate(policy, rooms, seeds)
    expected = [by_hand(config, policy, SCALES, seed) for seed in seeds]
    assert found.returns.tolist() == [e[0] for e in expected]
    assert found.lengths.tolist() == [e[1] for e in expected]
    assert found.terminated.tolist() == [e[2] for e in expected]
    again = evaluate(policy, rooms, seeds)
    assert all(np.array_equal(a, b) for a, b in zip(found, again, strict=True))


def test_the_state_of_the_lstm_matters(config):
    policy = restless(config)
    outcomes = [
        [by_hand(config, policy, SCALES, seed, keep)[:2] for seed in range(40)]
        for keep in (True, False)
    ]
    assert outcomes[0] != outcomes[1]


def test_only_the_first_episode_of_a_room_counts(config):
    zones = [zone.model_copy(update={"radius": 100.0}) for zone in config.navigation.zones]
    navigation = config.navigation.model_copy(update={"zones": zones, "max_episode_steps": 400})
    larger = config.model_copy(update={"navigation": navigation})
    policy, seeds = restless(larger), list(range(30))
    found = evaluate(policy, navigation_rooms(larger, len(seeds), SCALES), seeds)
    assert (
        set(found.returns[found.terminated]) <= {50.0, -20.0}
        and (found.returns[~found.terminated] == 0).all()
    )
    assert len(set(found.lengths)) > 3 and found.terminated.any()
    assert (
        found.success_rate == (found.returns > 0).mean()
        and found.dead_rate == (found.returns < 0).mean()
    )


# ---- runs ------------------------------------------------------------------------------------------------------------------


def run(config, folder, seed=0, action_space="full"):
    folder.mkdir(exist_ok=True)
    return train(config, action_space, seed, SCALES, Checkpoint(folder / "run.parquet", "settings"))


def same(a, b) -> bool:
    weights = zip(a[1]["policy"].values(), b[1]["policy"].values(), strict=True)
    return a[0].equals(b[0]) and all(torch.equal(x, y) for x, y in weights)


@pytest.fixture(scope="module")
def whole(config, tmp_path_factory):
    return run(config, tmp_path_factory.mktemp("whole"))


def test_the_same_run_gives_the_same_weights_bit_for_bit(config, whole, tmp_path):
    assert same(run(config, tmp_path), whole)
    assert whole[0]["step"].tolist() == [256, 512]


def test_another_seed_or_action_space_is_another_run(config, whole, tmp_path):
    assert not same(run(config, tmp_path / "a", seed=1), whole)
    assert not same(run(config, tmp_path / "b", action_space="truncated"), whole)


def test_a_killed_run_goes_on_as_if_it_had_not_been_killed(config, whole, tmp_path, monkeypatch):
    calls = []

    def killed(*args):
        calls.append(args)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return evaluate(*args)

    with monkeypatch.context() as patch:
        patch.setattr(training, "evaluate", killed)
        with pytest.raises(KeyboardInterrupt):
            run(config, tmp_path)
    torch.manual_seed(99)  # another process, another state of the world
    np.random.seed(99)  # noqa: NPY002  (what Stable-Baselines3 draws from)
    counted = []
    monkeypatch.setattr(training, "evaluate", lambda *args: (counted.append(1), evaluate(*args))[1])
    assert same(run(config, tmp_path), whole)
    assert len(counted) == 1  # the first segment was not done again


def test_a_model_plays_as_the_learner_did(config, whole, tmp_path):
    save_state(tmp_path / "full.0.policy", whole[1])
    policy = policy_of_run(config, load_state(tmp_path / "full.0.policy", ""), "full.0.policy")
    seeds = evaluation_seeds(config)
    found = evaluate(policy, navigation_rooms(config, len(seeds), SCALES), seeds)
    assert found.returns.mean() == whole[0]["episode_return"].iloc[-1]
    assert found.lengths.mean() == whole[0]["episode_length"].iloc[-1]


# ---- checkpoints -----------------------------------------------------------------------------------------------------------


DAMAGES = {
    "cut": lambda data: data[: len(data) // 2],
    "empty": lambda data: b"",
    "garbage": lambda data: b"not a checkpoint",
    "beheaded": lambda data: data[40:],
    "one bit": lambda data: data[:700] + bytes([data[700] ^ 1]) + data[701:],
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_checkpoint_is_named_and_left_alone(damage, tmp_path):
    checkpoint = Checkpoint(tmp_path / "run.parquet", "settings")
    checkpoint.save({"policy": {"weight": torch.ones(3)}, "curve": [{"step": 1}]})
    assert checkpoint.load()["curve"] == [{"step": 1}]
    spoilt = damage(checkpoint.path.read_bytes())
    checkpoint.path.write_bytes(spoilt)
    with pytest.raises(CheckpointError, match=f"{checkpoint.path}.*delete it"):
        checkpoint.load()
    assert checkpoint.path.read_bytes() == spoilt


def test_a_checkpoint_of_other_settings_is_not_used_and_forgotten_at_the_end(tmp_path):
    old, new = (Checkpoint(tmp_path / "run.parquet", settings) for settings in ("old", "new"))
    old.save({"curve": []})
    assert new.load() is None and old.load() is not None
    new.forget()
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def scp_file(config, tmp_path):
    """A navigation_scp table whose first four degrees of freedom have the lowest SCPs."""
    scp = pd.DataFrame(
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
        scp.assign(scp=[0.1 * i for i in range(8)]),
        tmp_path / "scp.parquet",
        config,
    )
    return tmp_path / "scp.parquet"


def test_a_run_is_written_with_its_model_and_leaves_no_checkpoint(config, scp_file, tmp_path):
    out = tmp_path / "runs" / "truncated.2.parquet"
    write_run(config, "truncated", 2, scp_file, out, tmp_path / "models" / "truncated.2.policy")
    assert [path.name for path in out.parent.iterdir()] == [out.name]
    model = load_state(tmp_path / "models" / "truncated.2.policy", "")
    assert list(model["scales"].values()) == [1.0] * 4 + [0.0] * 4
    curve = read_table("navigation_curves", out)
    assert curve["action_space"].unique().tolist() == ["truncated"] and curve["step"].tolist() == [
        256,
        512,
    ]


def test_a_damaged_checkpoint_stops_the_run_before_it_writes_anything(
    config, scp_file, tmp_path, monkeypatch
):
    monkeypatch.setattr(
        Checkpoint,
        "save",
        lambda self, state: (
            self.path.write_bytes(b"half"),
            (_ for _ in ()).throw(KeyboardInterrupt),
        ),
    )
    out = tmp_path / "full.0.parquet"
    with pytest.raises(KeyboardInterrupt):
        write_run(config, "full", 0, scp_file, out, tmp_path / "full.0.policy")
    with pytest.raises(CheckpointError):
        write_run(config, "full", 0, scp_file, out, tmp_path / "full.0.policy")
    assert not out.exists() and not (tmp_path / "full.0.policy").exists()


def test_the_table_of_action_spaces_says_what_the_runs_do(config, scp_file, tmp_path):
    write_action_spaces(scp_file, tmp_path / "spaces.parquet", config)
    table = read_table("navigation_action_spaces", tmp_path / "spaces.parquet")
    assert len(table) == 8 * len(config.navigation.runs)
    scp = measured_scp(config, read_table("navigation_scp", scp_file))
    for (space, seed), rows in table.groupby(["action_space", "seed"]):
        assert dict(zip(rows["dof"], rows["scale"], strict=True)) == scales_of_run(
            config, scp, space, seed
        )
