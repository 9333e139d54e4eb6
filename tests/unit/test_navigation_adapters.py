"""Rooms against Stable-Baselines3's own vector environment; evaluation against scripted episodes; wrappers around the task."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pandas as pd
import pytest
import torch
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from stable_baselines3.common.vec_env import DummyVecEnv, VecCheckNan, VecMonitor

from sensory_commutativity.navigation.action_spaces import (
    ACTION_SPACES,
    ScaledAction,
    ScaledActions,
    ScpError,
    action_scales,
    scp_of,
)
from sensory_commutativity.navigation.evaluation import Episodes, evaluate
from sensory_commutativity.navigation.rooms import Rooms
from sensory_commutativity.navigation.task import NavigationEnv, NavigationVectorEnv, Zone
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import Room

ROOM = Room(things=2, width=400.0, height=400.0, start_margin=80.0)
ZONES = (Zone(60.0, 60.0, 55.0, -20.0), Zone(330.0, 200.0, 65.0, 50.0))
FAST = Polyphemus(longitudinal_speed=15.0)
SCALES = [1.0, 0.25, 0.0, 0.0, 0.5, 0.0, 0.0, 0.75]
LIMIT, N = 12, 3


def rooms(reward_scale: float = 1.0) -> Rooms:
    return Rooms(
        ScaledActions(
            NavigationVectorEnv(N, ROOM, ZONES, FAST, LIMIT, AutoresetMode.SAME_STEP), SCALES
        ),
        reward_scale,
    )


# ---- Stable-Baselines3 -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("reward_scale", [1.0, 0.02])
def test_rooms_give_what_stable_baselines_own_vector_environment_gives(reward_scale):
    ours, theirs = (
        rooms(reward_scale),
        DummyVecEnv([lambda: ScaledAction(NavigationEnv(ROOM, ZONES, FAST, LIMIT), SCALES)] * N),
    )
    assert (
        ours.observation_space == theirs.observation_space
        and ours.action_space == theirs.action_space
    )
    theirs.seed(11)
    theirs._seeds = ours.seed(11)  # Stable-Baselines3's own are 11, 12, 13
    a, b = ours.reset(), theirs.reset()
    assert np.array_equal(a, b) and a.dtype == b.dtype
    rng, ends = np.random.default_rng(0), []
    for _ in range(60):
        actions = np.concatenate([np.ones((N, 1)), rng.uniform(-1.5, 1.5, (N, 3))], 1).astype(
            np.float32
        )
        found, expected = ours.step(actions), theirs.step(actions)
        assert np.array_equal(found[0], expected[0]) and found[0].dtype == expected[0].dtype
        assert (
            np.array_equal(found[1], (expected[1].astype(float) * reward_scale).astype(np.float32))
            and found[1].dtype == np.float32
        )
        assert np.array_equal(found[2], expected[2]) and found[2].dtype == bool
        for told, ended, other in zip(found[3], found[2], expected[3], strict=True):
            assert set(told) == (
                {"terminal_observation", "TimeLimit.truncated"} if ended else set()
            )
            if ended:
                assert np.array_equal(told["terminal_observation"], other["terminal_observation"])
                assert told["TimeLimit.truncated"] is other["TimeLimit.truncated"]
                ends.append(told["TimeLimit.truncated"])
    assert 4 < sum(ends) < len(ends) - 4
    assert np.array_equal(ours.reset(), theirs.reset())  # unseeded: the rooms' generators go on


def test_stable_baselines_wrappers_take_rooms():
    watched = VecMonitor(VecCheckNan(rooms(), raise_exception=True))
    watched.seed(0)
    watched.reset()
    told = [
        info["episode"]
        for _ in range(2 * LIMIT)
        for info in watched.step(np.zeros((N, 4), np.float32))[3]
        if "episode" in info
    ]
    assert [episode["l"] for episode in told] == [LIMIT] * 2 * N and all(
        episode["r"] == 0 for episode in told
    )


def test_rooms_are_one_thing():
    ours = rooms()
    assert (
        ours.num_envs == N
        and ours.get_attr("num_envs") == [N] * N
        and ours.get_attr("num_envs", [0, 2]) == [N] * 2
    )
    assert ours.env_is_wrapped(gym.Wrapper) == [False] * N and ours.get_images() == [None] * N
    for call in (lambda: ours.set_attr("num_envs", 3), lambda: ours.env_method("reset")):
        with pytest.raises(NotImplementedError):
            call()


def test_an_environment_that_does_not_say_how_it_resets_is_refused():
    environment = SyncVectorEnv(
        [lambda: NavigationEnv(ROOM, ZONES, FAST, LIMIT)], autoreset_mode=AutoresetMode.DISABLED
    )
    with pytest.raises(ValueError, match="SAME_STEP"):
        Rooms(environment)
    assert (
        Rooms(
            SyncVectorEnv(
                [lambda: NavigationEnv(ROOM, ZONES, FAST, LIMIT)],
                autoreset_mode=AutoresetMode.SAME_STEP,
            )
        ).num_envs
        == 1
    )


# ---- action spaces around the task -----------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_gymnasium_finds_no_fault_with_any_action_space():
    scp = {dof.name: 1 - 0.1 * i for i, dof in enumerate(FAST.dofs)}
    for name in ACTION_SPACES:
        scales = action_scales(name, scp, np.random.default_rng(0))
        check_env(
            ScaledAction(NavigationEnv(ROOM, ZONES, FAST, LIMIT), list(scales.values())),
            skip_render_check=True,
        )


def test_scaled_actions_move_the_agent_as_the_whole_action_would():
    scaled, whole = (
        ScaledAction(NavigationEnv(ROOM, ZONES, FAST, LIMIT), SCALES),
        NavigationEnv(ROOM, ZONES, FAST, LIMIT),
    )
    scaled.reset(seed=4), whole.reset(seed=4)
    assert (
        scaled.step(np.array([1, -1, 0.5, 2], np.float32))[1:]
        == whole.step(np.array([1, -0.25, 0, 0, 0.25, 0, 0, 0.75], np.float32))[1:]
    )
    assert np.array_equal(scaled.unwrapped.world.poses(), whole.world.poses())


class Foreign(gym.Env):
    """Three motors; it remembers what reached them."""

    observation_space = spaces.Box(-1, 1, (1,), np.float64)

    def __init__(self, dtype=np.float32):
        self.action_space, self.got = spaces.Box(-1, 1, (3,), dtype), []

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(1), {}

    def step(self, action):
        self.got.append(action)
        return np.zeros(1), 1.5, False, False, {"told": 1}


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_every_scaled_value_arrives_exactly(dtype):
    environment, scales = Foreign(dtype), np.array([0.3, 1.0, 0.7])
    wrapped = ScaledAction(environment, scales)
    assert wrapped.action_space == spaces.Box(-1, 1, (3,), dtype)
    wrapped.action_space.seed(0)
    sent = [wrapped.action_space.sample() for _ in range(50)]
    assert all(wrapped.step(action)[1:] == (1.5, False, False, {"told": 1}) for action in sent)
    assert np.array_equal(environment.got, (np.array(sent) * scales).astype(dtype))
    assert all(
        action.dtype == dtype and environment.action_space.contains(action)
        for action in environment.got
    )


def test_fixed_degrees_of_freedom_get_nothing_and_leave_the_space():
    environment = Foreign()
    wrapped = ScaledAction(environment, [0.0, 0.5, 0.0])
    for value in (-7.0, -0.5, 0.0, 0.5, 7.0):
        wrapped.step(np.array([value], np.float32))
    assert np.array_equal(
        environment.got,
        [(0, np.clip(value, -1, 1) / 2, 0) for value in (-7.0, -0.5, 0.0, 0.5, 7.0)],
    )


def test_the_learners_own_array_is_left_alone():
    sent = np.array([3.0, -3.0], np.float32)
    ScaledAction(Foreign(), [1.0, 0.0, 1.0]).step(sent)
    assert sent.tolist() == [3.0, -3.0]


def test_many_scaled_environments_get_what_single_ones_get():
    scales, singles = [0.2, 0.0, 0.9], [Foreign(), Foreign()]
    many = ScaledActions(SyncVectorEnv([lambda one=one: one for one in singles]), scales)
    alone, actions = Foreign(), np.random.default_rng(0).uniform(-2, 2, (2, 2)).astype(np.float32)
    many.reset()
    many.step(actions)
    for one, action in zip(singles, actions, strict=True):
        ScaledAction(alone, scales).step(action)
        assert np.array_equal(one.got[-1], alone.got[-1])


def test_scales_that_are_no_numbers_are_refused():
    with pytest.raises(ValueError, match=r"\[0, 1\]"):
        ScaledAction(Foreign(), [1.0, float("nan"), 0.0])
    with pytest.raises(ValueError, match="shape"):
        ScaledActions(SyncVectorEnv([Foreign]), [1.0, 1.0, 1.0, 1.0])


@pytest.mark.parametrize("scp", [-0.01, 1.01, float("nan")])
def test_an_scp_that_is_no_probability_is_refused(scp):
    table = pd.DataFrame(
        dict(world="w", agent="x", length=50, dof=["a", "b"], threshold=0.0, scp=[0.5, scp])
    )
    with pytest.raises(
        ScpError, match=r"'x' in 'w', length 50, threshold 0: the SCP of b is no probability"
    ):
        scp_of(table, ["a", "b"], "w", "x", 50)


# ---- evaluation ------------------------------------------------------------------------------------------------------------


class Script(VectorEnv):
    """Rooms that pay for every step: `ends` holds (step, by time?) of each room's first episode; the later ones end the other way."""

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
        over = np.array([self.steps % step == 0 for step, _ in self.ends])
        by_time = np.array([truncated == (self.steps == step) for step, truncated in self.ends])
        return (
            np.full((self.num_envs, 1), self.steps, np.float32),
            self.rewards * self.steps,
            over & ~by_time,
            over & by_time,
            {},
        )


class Clerk:
    """A policy that notes what it is asked and counts its steps in its state."""

    def __init__(self):
        self.asked = []

    def predict(self, observations, state, start, deterministic):
        self.asked.append((observations[:, 0].copy(), state, start.copy(), deterministic))
        return np.zeros((len(start), 1), np.float32), 1 if state is None else state + 1


def test_only_the_first_episode_of_each_room_is_counted():
    script = Script([(1, False), (3, False), (4, True), (2, True)], [1.0, -1.0, 2.0, -3.0])
    found = evaluate(Clerk(), script, [5, 6, 7, 8])
    assert script.seeds == [5, 6, 7, 8] and script.steps == 4
    assert found.returns.tolist() == [1, -(1 + 2 + 3), 2 * (1 + 2 + 3 + 4), -3 * (1 + 2)]
    assert found.lengths.tolist() == [1, 3, 4, 2] and found.lengths.dtype == np.int64
    assert found.terminated.tolist() == [True, True, False, False]
    assert (found.success_rate, found.dead_rate) == (0.25, 0.25)


def test_the_policys_state_goes_from_step_to_step_and_starts_are_told_once():
    clerk = Clerk()
    evaluate(clerk, Script([(3, False), (2, False)], [1.0, 1.0]), [0, 1])
    assert [state for _, state, _, _ in clerk.asked] == [None, 1, 2]
    assert [start.tolist() for *_, start, _ in clerk.asked] == [
        [True, True],
        [False, False],
        [False, False],
    ]
    assert [seen.tolist() for seen, *_ in clerk.asked] == [[0, 0], [1, 1], [2, 2]]
    assert all(deterministic for *_, deterministic in clerk.asked)


def test_time_that_runs_out_is_neither_success_nor_death():
    found = Episodes(
        np.array([50.0, -20.0, 0.0, 50.0, -20.0]),
        np.ones(5, np.int64),
        np.array([True, True, False, False, False]),
    )
    assert (found.success_rate, found.dead_rate) == (0.2, 0.2)


def test_evaluation_leaves_torchs_random_numbers_alone():
    before = torch.random.get_rng_state()
    evaluate(Clerk(), Script([(3, False)], [1.0]), [0])
    assert torch.equal(torch.random.get_rng_state(), before)
