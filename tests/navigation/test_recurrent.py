"""Minibatches of whole rollouts, and one update against sb3-contrib's own."""

from __future__ import annotations

import copy

import numpy as np
import pytest
import torch
from sb3_contrib import RecurrentPPO
from sb3_contrib.common.recurrent.buffers import RecurrentRolloutBuffer
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger

from sensory_commutativity.navigation.learner import make_learner
from sensory_commutativity.navigation.recurrent import WholeRolloutPPO
from sensory_commutativity.navigation.sb3 import Sb3VecEnv
from tests.navigation.small import LEARNER, TASK


class _Continue(BaseCallback):
    def _on_step(self) -> bool:
        return True


@pytest.fixture(scope="module")
def learner() -> WholeRolloutPPO:
    """A learner with a rollout that begins in the middle of episodes and contains their ends."""
    torch.set_num_threads(1)
    learner = make_learner(Sb3VecEnv(TASK.make_vector_env(LEARNER.rooms), 0.02), LEARNER, seed=0)
    learner.env.seed(1)
    _, callback = learner._setup_learn(10_000, _Continue())
    for _ in range(3):
        learner.collect_rollouts(learner.env, callback, learner.rollout_buffer, learner.n_steps)
    buffer = learner.rollout_buffer
    assert buffer.episode_starts[1:].sum() >= 4 and np.abs(buffer.hidden_states_pi[0]).max() > 0
    return learner


def test_minibatches_hold_every_transition_once(learner):
    buffer, steps = learner.rollout_buffer, learner.n_steps
    np.random.seed(0)  # noqa: NPY002  (the buffer draws from it)
    batches = list(buffer.get(2 * steps))
    assert [len(batch.returns) for batch in batches] == [2 * steps] * 2

    def joined(name: str) -> np.ndarray:
        parts = torch.cat([getattr(batch, name) for batch in batches])
        return parts.reshape(4, steps, *parts.shape[1:]).numpy()

    order = [int(np.flatnonzero((row == buffer.returns.T).all(1))[0]) for row in joined("returns")]
    assert sorted(order) == [0, 1, 2, 3]
    hidden = torch.cat([batch.lstm_states.pi[0] for batch in batches], 1).numpy()
    assert np.array_equal(hidden, buffer.hidden_states_pi[0][:, order])
    for name in ("actions", "observations", "advantages", "episode_starts"):
        values = getattr(buffer, name)[:, order].swapaxes(0, 1)
        assert np.array_equal(joined(name), values), name


def test_batch_sizes_that_cut_rollouts_are_rejected(learner):
    for size in (learner.n_steps + 1, 3 * learner.n_steps):
        with pytest.raises(ValueError, match=f"batch_size {size} must be"):
            next(learner.rollout_buffer.get(size))


def test_stored_actions_have_their_stored_values_and_log_probabilities(learner):
    """Before the first update, evaluating a rollout repeats what collecting it computed."""
    (batch,) = learner.rollout_buffer.get(None)
    values, log_prob, _ = learner.policy.evaluate_actions(
        batch.observations, batch.actions, batch.lstm_states, batch.episode_starts
    )
    assert torch.allclose(values.flatten(), batch.old_values, atol=1e-5)
    assert torch.allclose(log_prob, batch.old_log_prob, atol=1e-4)


def original_algorithm(learner: WholeRolloutPPO) -> RecurrentPPO:
    """sb3-contrib's own algorithm, policy and buffer, with the same weights and rollout."""
    original = RecurrentPPO(
        RecurrentActorCriticPolicy,
        learner.env,
        n_steps=learner.n_steps,
        batch_size=learner.n_steps * learner.n_envs,
        n_epochs=1,
        learning_rate=learner.learning_rate,
        ent_coef=learner.ent_coef,
        vf_coef=learner.vf_coef,
        max_grad_norm=learner.max_grad_norm,
        clip_range=learner.clip_range(1.0),
        gamma=learner.gamma,
        gae_lambda=learner.gae_lambda,
        policy_kwargs=learner.policy_kwargs,
        device="cpu",
    )
    original.policy.load_state_dict(learner.policy.state_dict())
    assert type(original.rollout_buffer) is RecurrentRolloutBuffer
    assert type(original.policy) is RecurrentActorCriticPolicy
    for name, value in vars(learner.rollout_buffer).items():
        if isinstance(value, np.ndarray):
            setattr(original.rollout_buffer, name, value.copy())
    original.rollout_buffer.full = True
    original.set_logger(Logger(folder=None, output_formats=[]))
    return original


def logged(algorithm: RecurrentPPO) -> dict[str, float]:
    values = algorithm.logger.name_to_value
    return {k: v for k, v in values.items() if k not in ("train/n_updates", "train/std")}


def test_an_update_has_the_loss_and_gradients_of_sb3_contribs_own(learner, monkeypatch):
    """Also with weights that have moved since the rollout: some probability ratios are clipped."""
    # sb3-contrib cuts one sequence at a random step; not here
    monkeypatch.setattr(np.random, "randint", lambda n: 0)
    monkeypatch.setattr(learner, "batch_size", learner.n_steps * learner.n_envs)
    monkeypatch.setattr(learner, "n_epochs", 1)
    weights = copy.deepcopy(learner.policy.state_dict())
    for drift in (0.0, 0.3):
        learner.policy.load_state_dict(weights)
        with torch.no_grad():
            torch.manual_seed(0)
            for weight in learner.policy.parameters():
                weight.add_(drift * weight.abs().mean() * torch.randn_like(weight))
        original = original_algorithm(learner)
        for algorithm in (learner, original):
            algorithm.train()
        log, expected = logged(learner), logged(original)
        assert log == pytest.approx(expected, rel=1e-4, abs=1e-5), drift
        assert drift == 0 or log["train/clip_fraction"] > 0.05
        pairs = zip(
            learner.policy.named_parameters(), original.policy.named_parameters(), strict=True
        )
        for (name, a), (_, b) in pairs:
            assert (a.grad is None) == (b.grad is None), name
            if b.grad is not None:
                tolerance = 1e-4 * float(b.grad.abs().max()) + 1e-8
                assert torch.allclose(a.grad, b.grad, rtol=1e-3, atol=tolerance), (name, drift)
    learner.policy.load_state_dict(weights)
