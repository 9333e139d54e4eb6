"""Flatland as a Gymnasium environment, for one room and for many."""

from __future__ import annotations

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from sensory_commutativity.worlds.flatland.environment import ENVIRONMENT_ID, FlatlandEnv
from sensory_commutativity.worlds.flatland.vector import FlatlandVectorEnv
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import EMPTY

N_ROOMS = 5


def test_gymnasium_s_checks_pass():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(FlatlandEnv(), skip_render_check=True)
    check_env(gymnasium.make(ENVIRONMENT_ID, render_mode="rgb_array").unwrapped)


def test_environment_equals_the_world():
    env, world = FlatlandEnv(), FlatlandWorld()
    view, _ = env.reset(seed=3)
    world.reset(np.random.Generator(np.random.PCG64(np.random.SeedSequence(3))))
    assert np.array_equal(view, world.observe())
    for action in np.random.default_rng(0).uniform(-1, 1, (40, 8)).astype(np.float32):
        view, reward, terminated, truncated, _ = env.step(action)
        world.step(action)
        assert np.array_equal(view, world.observe())
        assert (reward, terminated, truncated) == (0.0, False, False)


def test_equal_seeds_give_equal_episodes():
    views = []
    for seed in (1, 1, 2):
        env = FlatlandEnv()
        env.reset(seed=seed)
        env.action_space.seed(seed)
        views.append([env.step(env.action_space.sample())[0] for _ in range(50)])
    assert np.array_equal(views[0], views[1])
    assert not np.array_equal(views[0], views[2])


def test_gymnasium_make_truncates_and_never_terminates():
    env = gymnasium.make(ENVIRONMENT_ID, room=EMPTY)
    env.reset(seed=0)
    ends = [env.step(np.zeros(8, np.float32))[2:4] for _ in range(300)]
    assert ends == [(False, False)] * 299 + [(False, True)]


def test_rendering():
    with pytest.raises(ValueError, match="render_mode"):
        FlatlandEnv(render_mode="human")
    env = FlatlandEnv(render_mode="rgb_array")
    env.reset(seed=0)
    before = env.render()
    for _ in range(5):
        env.step(np.array([1, 0, 0, 0, 0, 0, 0, 0], np.float32))
    assert before.dtype == np.uint8 and before.shape == env.render().shape
    assert not np.array_equal(before, env.render())


def test_documented_actions_are_the_agent_s():
    lines = [line.split() for line in FlatlandEnv.__doc__.splitlines()]
    for i, dof in enumerate(FlatlandEnv().world.dofs):
        row = next(words for words in lines if dof.name in words)
        assert row[0] == str(i) and float(row[2]) == dof.speed and row[3] == dof.unit


# ---- the vector environment ----------------------------------------------------------------------


def test_every_room_equals_a_single_environment():
    vector = FlatlandVectorEnv(N_ROOMS, max_episode_steps=30)
    rooms = [gymnasium.wrappers.TimeLimit(FlatlandEnv(), 30) for _ in range(N_ROOMS)]
    views, _ = vector.reset(seed=11)
    assert np.array_equal(views, [room.reset(seed=11 + i)[0] for i, room in enumerate(rooms)])
    ended = np.zeros(N_ROOMS, bool)
    for actions in np.random.default_rng(0).uniform(-1, 1, (70, N_ROOMS, 8)).astype(np.float32):
        views, rewards, terminated, truncated, _ = vector.step(actions)
        results = [
            room.reset() if end else room.step(action)
            for room, action, end in zip(rooms, actions, ended, strict=True)
        ]
        assert np.array_equal(views, [result[0] for result in results])
        ended = np.array([len(result) == 5 and result[3] for result in results])
        assert np.array_equal(truncated, ended) and not terminated.any() and not rewards.any()
    assert not np.array_equal(views[0], views[1])


def test_vector_returns_new_arrays():
    vector = FlatlandVectorEnv(2)
    first, _ = vector.reset(seed=0)
    copy = first.copy()
    vector.step(np.ones((2, 8), np.float32))
    assert np.array_equal(first, copy)


def test_vector_reset_with_and_without_a_seed():
    vector = FlatlandVectorEnv(2)
    first = vector.reset(seed=np.int64(5))[0]
    assert not np.array_equal(first, vector.reset()[0])
    assert np.array_equal(vector.reset(seed=5)[0], first)
    assert np.array_equal(vector.reset(seed=[5, 6])[0], first)
    kept, reseeded = vector.reset(seed=[None, 6])[0]  # without a seed, a room's generator goes on
    assert np.array_equal(reseeded, first[1]) and not np.array_equal(kept, first[0])
    with pytest.raises(ValueError, match="2 seeds"):
        vector.reset(seed=[1, 2, 3])


def test_vector_refuses_invalid_actions():
    vector = FlatlandVectorEnv(2)
    with pytest.raises(RuntimeError, match="reset"):
        vector.step(np.zeros((2, 8)))
    vector.reset(seed=0)
    for actions in (np.zeros((3, 8)), np.zeros((2, 7)), np.full((2, 8), np.nan)):
        with pytest.raises(ValueError, match="action"):
            vector.step(actions)


def test_gymnasium_makes_the_vector():
    vector = gymnasium.make_vec(ENVIRONMENT_ID, num_envs=2, vectorization_mode="vector_entry_point")
    assert isinstance(vector, FlatlandVectorEnv) and vector.num_envs == 2
