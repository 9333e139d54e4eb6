"""Gymnasium environments as worlds."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces

from sensory_commutativity import (
    ArgumentError,
    Corridor,
    FlatlandWorld,
    WorldError,
    as_world,
    check_world,
    from_gymnasium,
    measure,
)
from sensory_commutativity.worlds.flatland.environment import ENVIRONMENT_ID


class Reach(gym.Env):
    """A point that is moved; the second element of an action has a one-sided range."""

    observation_space = spaces.Dict(
        {"point": spaces.Box(-np.inf, np.inf, (2,)), "lamp": spaces.Discrete(2)}
    )
    action_space = spaces.Box(np.float32([-2, 0]), np.float32([4, 1]))
    ends_after = 10_000

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.point, self.steps = self.np_random.integers(-5, 5, 2).astype(float), 0
        return self.observation(), {}

    def step(self, action):
        assert self.action_space.contains(action)
        self.point += action
        self.steps += 1
        return self.observation(), 0.0, self.steps >= self.ends_after, False, {}

    def observation(self):
        return {"point": self.point.copy(), "lamp": 1}


def test_environments_keep_the_promises_of_a_world() -> None:
    for env in (Reach(), gym.make("Pendulum-v1", max_episode_steps=1000)):
        report = check_world(from_gymnasium(env))
        assert report.passed, str(report)


def test_the_adapter_measures_what_the_world_itself_does() -> None:
    env = gym.make(ENVIRONMENT_ID)
    assert check_world(as_world(env), tries=3).passed
    table = measure(env, n=3, length=5).table
    assert len(table) == 2 * len(FlatlandWorld().dofs)


def test_actions_reach_the_ends_of_their_range_and_zero_commands_zero() -> None:
    world = from_gymnasium(Reach(), sensors=["point"])
    world.reset(np.random.default_rng(0))
    start = world.observe()
    assert start.shape == (2,)
    moved = []
    for action in ([1, 1], [-1, -1], [0, 0], [9, 0.5]):
        before = world.observe()
        world.step(np.array(action, float))
        moved.append((world.observe() - before).tolist())
    assert moved == [[4, 1], [-2, 0], [0, 0], [4, 0.5]]


def test_an_episode_that_terminates_goes_on_and_says_so() -> None:
    env = Reach()
    env.ends_after = 62  # two steps after the start
    world = from_gymnasium(env)
    world.reset(np.random.default_rng(0))
    start = world.snapshot()
    for _ in range(2):
        world.step(np.ones(2))
    assert world.happened().terminated
    ended = world.observe()
    world.step(np.ones(2))
    assert not np.array_equal(world.observe(), ended)
    world.restore(start)
    world.observe()
    assert not world.happened().terminated


def test_environments_that_cannot_be_measured_are_refused() -> None:
    with pytest.raises(ArgumentError, match=r"env: CartPole-v1 has actions in Discrete"):
        measure(gym.make("CartPole-v1"))
    env = Reach()
    env.action_space = spaces.Box(-np.inf, np.inf, (2,))
    with pytest.raises(ArgumentError, match=r"env: Reach has unbounded actions"):
        from_gymnasium(env)
    with pytest.raises(ArgumentError, match=r"sensors: Reach has no 'lidar'; choose from "):
        from_gymnasium(Reach(), sensors=["lidar"])


def test_limits_of_steps_are_lifted() -> None:
    assert len(measure(gym.make("Pendulum-v1", max_episode_steps=6), n=2, length=30)) == 2


class Truncates(Reach):
    def step(self, action):
        observation, reward, terminated, _, info = super().step(action)
        return observation, reward, terminated, self.steps > 70, info


def test_an_environment_that_truncates_itself_is_refused() -> None:
    with pytest.raises(WorldError, match=r"truncates"):
        measure(Truncates(), n=2, length=30)


def test_as_world_takes_worlds_and_functions() -> None:
    world = Corridor()
    assert as_world(world) is world
    assert isinstance(as_world(lambda: Corridor()), Corridor)


def test_a_start_may_be_the_reset_itself() -> None:
    world = from_gymnasium(Reach(), prefix=0, settle=0)
    world.reset(np.random.default_rng(0))
    assert (np.abs(world.observe()[1:]) <= 5).all()


def test_sensors_of_the_world_need_contacts() -> None:
    with pytest.raises(ArgumentError, match="world needs a simulator that tells what touches"):
        from_gymnasium(Reach(), sensors=["world"])


class SameArray(gym.Env):
    """A point that moves on while nothing is commanded; every observation is the same array."""

    observation_space = spaces.Box(-np.inf, np.inf, (1,), np.float64)
    action_space = spaces.Box(-1, 1, (1,), np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.point = np.zeros(1)
        return self.point, {}

    def step(self, action):
        self.point += 1.0 + action
        return self.point, 0.0, False, False, {}


def test_an_environment_that_returns_one_array_again_is_seen_to_move() -> None:
    world = from_gymnasium(SameArray())
    world.reset(np.random.default_rng(0))
    world.restore(world.snapshot())
    world.rest(7)
    assert world.happened().rest_steps == 7 and not world.happened().still
