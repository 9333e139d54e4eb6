"""Flatland as a Gymnasium environment, one room and many."""

from __future__ import annotations

import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from sensory_commutativity.worlds.flatland.environment import ENVIRONMENT_ID, FlatlandEnv
from sensory_commutativity.worlds.flatland.room import Room
from sensory_commutativity.worlds.flatland.vector import FlatlandVectorEnv
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

ROOMS = 5


def test_gymnasium_finds_nothing_wrong():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(FlatlandEnv(), skip_render_check=True)
    check_env(gymnasium.make(ENVIRONMENT_ID, render_mode="rgb_array").unwrapped)


def test_it_is_the_world():
    environment, world = FlatlandEnv(), FlatlandWorld()
    view, _ = environment.reset(seed=3)
    world.reset(np.random.Generator(np.random.PCG64(np.random.SeedSequence(3))))
    assert np.array_equal(view, world.observe())
    for action in np.random.default_rng(0).uniform(-1, 1, (40, 8)).astype(np.float32):
        view, reward, terminated, truncated, _ = environment.step(action)
        world.step(action)
        assert np.array_equal(view, world.observe()) and (reward, terminated, truncated) == (
            0.0,
            False,
            False,
        )


def test_two_with_the_same_seed_are_equal_and_with_another_not():
    views = []
    for seed in (1, 1, 2):
        environment = FlatlandEnv()
        environment.reset(seed=seed)
        environment.action_space.seed(seed)
        views.append([environment.step(environment.action_space.sample())[0] for _ in range(50)])
    assert np.array_equal(views[0], views[1])
    assert not np.array_equal(views[0], views[2])


def test_made_by_gymnasium_it_is_truncated_and_never_terminated():
    environment = gymnasium.make(ENVIRONMENT_ID, room=Room(things=0))
    environment.reset(seed=0)
    ends = [environment.step(np.zeros(8, np.float32))[2:4] for _ in range(300)]
    assert ends == [(False, False)] * 299 + [(False, True)]


def test_an_unknown_render_mode_is_refused():
    with pytest.raises(ValueError, match="render_mode"):
        FlatlandEnv(render_mode="human")


def test_the_picture_changes_when_the_agent_moves():
    environment = FlatlandEnv(render_mode="rgb_array")
    environment.reset(seed=0)
    before = environment.render()
    for _ in range(5):
        environment.step(np.array([1, 0, 0, 0, 0, 0, 0, 0], np.float32))
    assert before.dtype == np.uint8 and before.shape == environment.render().shape
    assert not np.array_equal(before, environment.render())


def test_the_documented_speeds_are_the_agents():
    text = FlatlandEnv.__doc__
    for i, dof in enumerate(FlatlandEnv().world.dofs):
        row = next(line.split() for line in text.splitlines() if dof.name in line.split())
        assert row[0] == str(i) and float(row[2]) == dof.speed and row[3] == dof.unit


def test_every_room_of_the_vector_is_a_room_of_its_own():
    vector = FlatlandVectorEnv(ROOMS, max_episode_steps=30)
    rooms = [gymnasium.wrappers.TimeLimit(FlatlandEnv(), 30) for _ in range(ROOMS)]
    views, _ = vector.reset(seed=11)
    assert np.array_equal(views, [room.reset(seed=11 + i)[0] for i, room in enumerate(rooms)])
    ended = np.zeros(ROOMS, bool)
    for actions in np.random.default_rng(0).uniform(-1, 1, (70, ROOMS, 8)).astype(np.float32):
        views, rewards, terminated, truncated, _ = vector.step(actions)
        steps = [
            room.reset() if end else room.step(action)
            for room, action, end in zip(rooms, actions, ended, strict=True)
        ]
        assert np.array_equal(views, [step[0] for step in steps])
        ended = np.array([len(step) == 5 and step[3] for step in steps])
        assert np.array_equal(truncated, ended) and not terminated.any() and not rewards.any()
    assert not np.array_equal(views[0], views[1])


def test_the_vector_gives_new_arrays():
    vector = FlatlandVectorEnv(2)
    first, _ = vector.reset(seed=0)
    kept = first.copy()
    vector.step(np.ones((2, 8), np.float32))
    assert np.array_equal(first, kept)


def test_the_vector_is_reset_again_with_and_without_a_seed():
    vector = FlatlandVectorEnv(2)
    first = vector.reset(seed=np.int64(5))[0]
    other = vector.reset()[0]
    assert not np.array_equal(first, other)
    assert np.array_equal(vector.reset(seed=5)[0], first)
    assert np.array_equal(vector.reset(seed=[5, 6])[0], first)


@pytest.mark.parametrize("actions", [np.zeros((3, 8)), np.zeros((2, 7)), np.full((2, 8), np.nan)])
def test_the_vector_refuses_wrong_actions(actions):
    vector = FlatlandVectorEnv(2)
    with pytest.raises(RuntimeError, match="reset"):
        vector.step(np.zeros((2, 8)))
    vector.reset(seed=0)
    with pytest.raises(ValueError, match="action"):
        vector.step(actions)


def test_a_wrong_number_of_seeds_is_refused():
    with pytest.raises(ValueError, match="2 seeds"):
        FlatlandVectorEnv(2).reset(seed=[1, 2, 3])


def test_gymnasium_makes_the_vector():
    vector = gymnasium.make_vec(ENVIRONMENT_ID, num_envs=2, vectorization_mode="vector_entry_point")
    assert isinstance(vector, FlatlandVectorEnv) and vector.num_envs == 2
