"""Action spaces derived from SCPs, and the wrappers on other people's environments."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pandas as pd
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import SyncVectorEnv

from sensory_commutativity import from_gymnasium, make_environment, measure
from sensory_commutativity.navigation.action_spaces import (
    ACTION_SPACES,
    ScaledAction,
    ScpError,
    VectorScaledAction,
    action_scales,
    scp_from_table,
    wrap_action_space,
)
from tests.navigation.small import SCALES, TASK

SCP = {"a": 0.9, "b": 0.5, "c": 1.0, "d": 0.6}


def kept(action_space: str, scp: dict[str, float], rng=None) -> set[str]:
    return {dof for dof, scale in action_scales(action_space, scp, rng).items() if scale}


def test_scales_of_every_action_space():
    assert action_scales("full", SCP) == {"a": 1, "b": 1, "c": 1, "d": 1}
    assert action_scales("truncated", SCP) == {"a": 0, "b": 1, "c": 0, "d": 1}
    assert action_scales("inverse", SCP) == {"a": 1, "b": 0, "c": 1, "d": 0}
    assert action_scales("adapted", SCP) == pytest.approx({"a": 0.2, "b": 1.0, "c": 0.0, "d": 0.8})
    based = {**SCP, "base-x": 0.5}
    for name in ACTION_SPACES:
        assert list(action_scales(name, based, np.random.default_rng(0))) == list(based)
    with pytest.raises(ValueError, match="truncated"):
        action_scales("shortened", SCP)


def test_adapted_ends_exactly_at_one_and_zero_and_keeps_all_if_all_scps_are_equal():
    scales = action_scales("adapted", {"a": 0.1, "b": 0.3, "c": 0.7})
    assert scales["a"] == 1.0 and scales["c"] == 0.0
    assert set(action_scales("adapted", {"a": 0.4, "b": 0.4}).values()) == {1.0}


def test_ties_keep_the_order_of_the_actions_and_odd_numbers_the_larger_half():
    equal = dict.fromkeys("abc", 1.0)
    assert kept("truncated", equal) == {"a", "b"}
    assert kept("inverse", equal) == {"b", "c"}
    assert len(kept("random-half", equal, np.random.default_rng(0))) == 2


def test_random_half_draws_from_its_generator():
    scp = dict.fromkeys("abcdefgh", 0.5)
    halves = {frozenset(kept("random-half", scp, np.random.default_rng(i))) for i in range(12)}
    assert {len(half) for half in halves} == {4} and len(halves) > 6
    with pytest.raises(ValueError, match="generator"):
        action_scales("random-half", scp)


def test_base_and_random_keeps_the_base_and_half_of_all():
    scp = {"base-longitudinal": 0.9, "base-rotation": 0.8, **dict.fromkeys("abcdef", 0.5)}
    halves = {frozenset(kept("base-random", scp, np.random.default_rng(i))) for i in range(40)}
    assert all(len(half) == 4 and {"base-longitudinal", "base-rotation"} < half for half in halves)
    assert len(halves) > 10
    with pytest.raises(ValueError, match="generator"):
        action_scales("base-random", scp)
    for names in ("abcd", ("base-a", "base-b", "base-c", "d")):
        with pytest.raises(ValueError, match="base-random needs degrees of freedom called base-"):
            action_scales("base-random", dict.fromkeys(names, 0.5), np.random.default_rng(0))


class Recorder(gym.Env):
    """Three motors; records the actions that it receives."""

    observation_space = spaces.Box(-1, 1, (1,), np.float64)

    def __init__(self, dtype=np.float32, limit: float = 1.0):
        self.action_space = spaces.Box(-limit, limit, (3,), dtype)
        self.actions: list[np.ndarray] = []

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(1), {}

    def step(self, action):
        self.actions.append(action)
        return np.zeros(1), 1.5, False, False, {"note": 1}


def test_every_scaled_value_arrives_exactly():
    for dtype in (np.float32, np.float64):
        env, scales = Recorder(dtype), np.array([0.3, 1.0, 0.7])
        wrapped = ScaledAction(env, scales)
        assert wrapped.action_space == spaces.Box(-1, 1, (3,), dtype)
        wrapped.action_space.seed(0)
        sent = [wrapped.action_space.sample() for _ in range(50)]
        assert all(wrapped.step(action)[1:] == (1.5, False, False, {"note": 1}) for action in sent)
        assert np.array_equal(env.actions, (np.array(sent) * scales).astype(dtype))
        assert all(a.dtype == dtype and env.action_space.contains(a) for a in env.actions)


def test_actions_are_clipped_and_removed_degrees_of_freedom_receive_zero():
    env = Recorder()
    wrapped = ScaledAction(env, [0.5, 0.0, 1.0])
    assert wrapped.action_space == spaces.Box(-1, 1, (2,), np.float32)
    action = np.array([4.0, -3.0], np.float32)
    wrapped.step(action)
    wrapped.step(np.array([1.0, -0.25], np.float32))
    assert np.array_equal(env.actions, [(0.5, 0.0, -1.0), (0.5, 0.0, -0.25)])
    assert action.tolist() == [4.0, -3.0]  # the caller's array is unchanged
    with pytest.raises(ValueError, match=r"\(2,\), got \(3,\)"):
        wrapped.step(np.zeros(3, np.float32))


def test_the_vector_wrapper_agrees_with_the_single_one():
    envs = [Recorder(), Recorder()]
    scales = [0.2, 0.0, 0.9]
    vector = VectorScaledAction(SyncVectorEnv([lambda env=env: env for env in envs]), scales)
    assert vector.single_action_space.shape == (2,) and vector.action_space.shape == (2, 2)
    actions = np.random.default_rng(0).uniform(-2, 2, (2, 2)).astype(np.float32)
    vector.reset()
    vector.step(actions)
    for env, action in zip(envs, actions, strict=True):
        single = Recorder()
        ScaledAction(single, scales).step(action)
        assert np.array_equal(env.actions[-1], single.actions[-1])
    with pytest.raises(ValueError, match=r"\(2, 2\), got \(3, 2\)"):
        vector.step(np.zeros((3, 2), np.float32))


def test_invalid_scales_and_action_spaces_are_rejected():
    for scales, message in [
        ([1.0, 1.0], "shape"),
        ([1.0, 2.0, 0.0], r"\[0, 1\]"),
        ([-0.1, 1, 1], r"\[0, 1\]"),
        ([1.0, float("nan"), 0.0], r"\[0, 1\]"),
        ([0, 0, 0], "empty"),
    ]:
        with pytest.raises(ValueError, match=message):
            ScaledAction(Recorder(), scales)
        with pytest.raises(ValueError, match=message):
            VectorScaledAction(SyncVectorEnv([Recorder]), scales)
    with pytest.raises(ValueError, match="rescale"):
        ScaledAction(Recorder(limit=2.0), [1, 1, 1])
    with pytest.raises(ValueError, match="Box of floats"):
        ScaledAction(gym.make("CartPole-v1"), [1, 1])


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_wrapped_environments_pass_gymnasiums_checks():
    scp = {dof.name: 1 - 0.1 * i for i, dof in enumerate(TASK.agent.dofs)}
    for name in ACTION_SPACES:
        scales = action_scales(name, scp, np.random.default_rng(0))
        check_env(ScaledAction(TASK.make_env(), list(scales.values())), skip_render_check=True)


def test_scaled_actions_move_the_agent_like_the_full_action():
    scaled, full = ScaledAction(TASK.make_env(), list(SCALES.values())), TASK.make_env()
    scaled.reset(seed=4)
    full.reset(seed=4)
    result = scaled.step(np.array([1, -1, 0.5, 2], np.float32))
    expected = full.step(np.array([1, -0.5, 0, 0, 0.125, 0, 0, 0.1], np.float32))
    assert np.array_equal(result[0], expected[0]) and result[1:] == expected[1:]
    assert np.array_equal(scaled.unwrapped.world.poses(), full.world.poses())


def scp_table(**changes) -> pd.DataFrame:
    rows = dict(world="w", agent="x", length=50, dof=list("abc"), threshold=0.0)
    return pd.DataFrame(rows | dict(scp=[0.5, 0.7, 1.0]) | changes)


def test_scps_are_selected_from_a_table_in_the_order_of_the_actions():
    others = [dict(world="v"), dict(agent="y"), dict(length=10), dict(threshold=1.0)]
    table = pd.concat([scp_table(), *(scp_table(scp=0.1, **change) for change in others)])
    assert scp_from_table(table, ["c", "a", "b"], "w", "x", 50) == {"c": 1.0, "a": 0.5, "b": 0.7}


def test_missing_repeated_and_invalid_scps_are_rejected():
    for table, message in [
        (scp_table()[:2], "no row for c"),
        (scp_table(threshold=1.0), "no row for a, b, c"),
        (scp_table(agent="y"), "no row for a, b, c"),
        (pd.concat([scp_table(), scp_table()[1:2]]), "more than one row for b"),
        (scp_table(scp=[0.5, float("nan"), 1.0]), "SCP of b"),
        (scp_table(scp=[0.5, -0.01, 1.0]), "SCP of b"),
        (scp_table(scp=[0.5, 0.6, 1.01]), "'x' in 'w', length 50, threshold 0: the SCP of c"),
    ]:
        with pytest.raises(ScpError, match=message):
            scp_from_table(table, list("abc"), "w", "x", 50)


def test_an_environment_is_wrapped_by_a_measurement_in_one_call():
    env = make_environment("Reacher-v5")
    measured = measure(from_gymnasium(make_environment("Reacher-v5")), n=3, length=5)
    assert wrap_action_space(env, measured, "full").action_space.shape == (2,)
    pusher = make_environment("Pusher-v5")  # whose actions lie in [-2, 2]
    scp = {f"joint-{i}": 0.1 * i for i in range(7)}
    reduced = wrap_action_space(pusher, scp)
    assert reduced.action_space.shape == (4,)
    reduced.reset(seed=0)
    reduced.step(reduced.action_space.sample())
    with pytest.raises(ValueError, match="scales have the shape"):
        wrap_action_space(env, scp)
