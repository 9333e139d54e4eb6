"""The adapter for Stable-Baselines3, against the vector environment of Stable-Baselines3 itself."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from stable_baselines3.common.vec_env import DummyVecEnv, VecCheckNan, VecMonitor

from sensory_commutativity.navigation.action_spaces import ScaledAction
from sensory_commutativity.navigation.sb3 import Sb3VecEnv
from sensory_commutativity.navigation.training import make_scaled_rooms
from tests.navigation.small import SCALES, TASK

N = 3
LIMIT = TASK.max_episode_steps


def make_adapter(reward_scale: float = 1.0) -> Sb3VecEnv:
    return Sb3VecEnv(make_scaled_rooms(TASK, N, SCALES), reward_scale)


def test_the_adapter_gives_what_stable_baselines_own_vector_environment_gives():
    for scale in (1.0, 0.02):
        ours = make_adapter(scale)
        theirs = DummyVecEnv([lambda: ScaledAction(TASK.make_env(), list(SCALES.values()))] * N)
        assert ours.observation_space == theirs.observation_space
        assert ours.action_space == theirs.action_space
        theirs.seed(11)
        theirs._seeds = ours.seed(11)  # Stable-Baselines3 would use 11, 12, 13
        a, b = ours.reset(), theirs.reset()
        assert np.array_equal(a, b) and a.dtype == b.dtype
        rng, by_time = np.random.default_rng(0), []
        for _ in range(60):
            turns = rng.uniform(-1.5, 1.5, (N, 3))
            actions = np.concatenate([np.ones((N, 1)), turns], 1).astype(np.float32)
            result, expected = ours.step(actions), theirs.step(actions)
            rewards = (expected[1].astype(float) * scale).astype(np.float32)
            for a, b in zip(result[:3], (expected[0], rewards, expected[2]), strict=True):
                assert np.array_equal(a, b) and a.dtype == b.dtype
            for info, done, other in zip(result[3], result[2], expected[3], strict=True):
                if not done:
                    assert info == {}
                    continue
                assert set(info) == {"terminal_observation", "TimeLimit.truncated"}
                assert np.array_equal(info["terminal_observation"], other["terminal_observation"])
                assert info["TimeLimit.truncated"] is other["TimeLimit.truncated"]
                by_time.append(info["TimeLimit.truncated"])
        assert 4 < sum(by_time) < len(by_time) - 4
        assert np.array_equal(ours.reset(), theirs.reset())  # without seeds, generators continue


def test_seeds_apply_to_the_next_reset_only():
    a, b = make_adapter(), make_adapter()
    for adapter in (a, b):
        adapter.seed(3)
    first = a.reset()
    assert np.array_equal(first, b.reset())
    b.seed(4)
    assert not np.array_equal(a.reset(), first) and not np.array_equal(b.reset(), first)


def test_wrappers_of_stable_baselines_accept_the_adapter():
    monitored = VecMonitor(VecCheckNan(make_adapter(), raise_exception=True))
    monitored.seed(0)
    monitored.reset()
    infos = [
        info["episode"]
        for _ in range(2 * LIMIT)
        for info in monitored.step(np.zeros((N, 4), np.float32))[3]
        if "episode" in info
    ]
    assert [info["l"] for info in infos] == [LIMIT] * 2 * N
    assert all(info["r"] == 0 for info in infos)


def test_sub_environments_are_not_accessible():
    adapter = make_adapter()
    assert adapter.get_attr("num_envs") == [N] * N and adapter.get_attr("num_envs", [0]) == [N]
    assert adapter.env_is_wrapped(gym.Wrapper) == [False] * N
    assert adapter.get_images() == [None] * N
    for call in (lambda: adapter.set_attr("num_envs", 3), lambda: adapter.env_method("reset")):
        with pytest.raises(NotImplementedError):
            call()


def test_only_same_step_autoreset_is_accepted():
    for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.DISABLED):
        with pytest.raises(ValueError, match="SAME_STEP"):
            Sb3VecEnv(SyncVectorEnv([TASK.make_env], autoreset_mode=mode))
    env = SyncVectorEnv([TASK.make_env], autoreset_mode=AutoresetMode.SAME_STEP)
    assert Sb3VecEnv(env).num_envs == 1
