"""Evaluation, against scripted episodes and against episodes played one by one."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from gymnasium import spaces
from gymnasium.vector import VectorEnv

from sensory_commutativity.navigation.action_spaces import ScaledAction
from sensory_commutativity.navigation.evaluation import Episodes, evaluate
from sensory_commutativity.navigation.learner import make_policy
from sensory_commutativity.navigation.training import make_scaled_rooms
from tests.navigation.small import LEARNER, SCALES, TASK


class ScriptedEnv(VectorEnv):
    """Sub-environments that pay k times their reward in step k.

    `ends` holds (step, by the time limit?) of the first episode of each; later episodes end the
    other way.
    """

    single_observation_space = spaces.Box(0, 255, (1,), np.float32)
    single_action_space = spaces.Box(-1, 1, (1,), np.float32)

    def __init__(self, ends, rewards):
        self.num_envs, self.ends, self.rewards = len(ends), ends, np.asarray(rewards, float)
        self.seeds, self.steps = [], 0

    def reset(self, *, seed=None, options=None):
        self.seeds, self.steps = seed, 0
        return np.zeros((self.num_envs, 1), np.float32), {}

    def step(self, actions):
        self.steps += 1
        done = np.array([self.steps % step == 0 for step, _ in self.ends])
        by_time = np.array([truncated == (self.steps == step) for step, truncated in self.ends])
        observations = np.full((self.num_envs, 1), self.steps, np.float32)
        return observations, self.rewards * self.steps, done & ~by_time, done & by_time, {}


class RecordingPolicy:
    """Records its arguments; its state counts the steps."""

    def __init__(self):
        self.calls = []

    def predict(self, observations, state, episode_starts, deterministic):
        self.calls.append(
            (observations[:, 0].tolist(), state, episode_starts.tolist(), deterministic)
        )
        actions = np.zeros((len(episode_starts), 1), np.float32)
        return actions, 1 if state is None else state + 1


def test_only_the_first_episode_of_each_sub_environment_counts():
    env = ScriptedEnv([(1, False), (3, False), (4, True), (2, True)], [1.0, -1.0, 2.0, -3.0])
    episodes = evaluate(RecordingPolicy(), env, [5, 6, 7, 8])
    assert env.seeds == [5, 6, 7, 8] and env.steps == 4
    assert episodes.returns.tolist() == [1, -(1 + 2 + 3), 2 * (1 + 2 + 3 + 4), -3 * (1 + 2)]
    assert episodes.lengths.tolist() == [1, 3, 4, 2] and episodes.lengths.dtype == np.int64
    assert episodes.terminated.tolist() == [True, True, False, False]
    assert (episodes.success_rate, episodes.dead_rate) == (0.25, 0.25)


def test_the_recurrent_state_is_passed_from_step_to_step():
    policy = RecordingPolicy()
    random_state = torch.random.get_rng_state()
    evaluate(policy, ScriptedEnv([(3, False), (2, False)], [1.0, 1.0]), [0, 1])
    assert policy.calls == [
        ([0, 0], None, [True, True], True),
        ([1, 1], 1, [False, False], True),
        ([2, 2], 2, [False, False], True),
    ]
    assert torch.equal(torch.random.get_rng_state(), random_state)  # nothing was drawn


def test_episodes_that_end_by_time_are_neither_success_nor_death():
    returns = np.array([50.0, -20.0, 0.0, 50.0, -20.0])
    terminated = np.array([True, True, False, False, False])
    episodes = Episodes(returns, np.ones(5, np.int64), terminated)
    assert (episodes.success_rate, episodes.dead_rate) == (0.2, 0.2)


@pytest.fixture(scope="module")
def restless():
    """A policy whose actions depend on its state: its output weights are large."""
    torch.set_num_threads(1)
    torch.manual_seed(1)
    rooms = make_scaled_rooms(TASK, 1, SCALES)
    policy = make_policy(rooms.single_observation_space, rooms.single_action_space, LEARNER)
    with torch.no_grad():
        policy.action_net.weight.mul_(300)
    return policy


def play_alone(policy, seed: int, keep_state: bool = True) -> tuple[float, int, bool]:
    """Return, length and termination of one episode in a single environment."""
    env = ScaledAction(TASK.make_env(), list(SCALES.values()))
    observation, _ = env.reset(seed=seed)
    state, starts, total, length = None, np.ones(1, bool), 0.0, 0
    while True:
        action, state = policy.predict(
            observation[None], state if keep_state else None, starts, deterministic=True
        )
        starts = np.zeros(1, bool)
        observation, reward, terminated, truncated, _ = env.step(action[0])
        total, length = total + reward, length + 1
        if terminated or truncated:
            return total, length, terminated


def test_evaluation_equals_episodes_played_one_by_one(restless):
    seeds = list(range(30))
    rooms = make_scaled_rooms(TASK, len(seeds), SCALES)
    episodes = evaluate(restless, rooms, seeds)
    expected = [play_alone(restless, seed) for seed in seeds]
    assert list(zip(*(values.tolist() for values in episodes), strict=True)) == expected
    assert episodes.terminated.any() and not episodes.terminated.all()
    repeated = evaluate(restless, rooms, seeds)
    assert all(np.array_equal(a, b) for a, b in zip(episodes, repeated, strict=True))
    assert [play_alone(restless, seed, keep_state=False) for seed in seeds] != expected
