"""Action spaces from SCPs, and the wrappers on an environment that is not ours."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pandas as pd
import pytest
from gymnasium import spaces
from gymnasium.vector import SyncVectorEnv

from sensory_commutativity.navigation.action_spaces import (
    ACTION_SPACES,
    ScaledAction,
    ScaledActions,
    ScpError,
    action_scales,
    scp_of,
)
from sensory_commutativity.studies.navigation.builders import scales_of_run

SCP = {"a": 0.9, "b": 0.5, "c": 1.0, "d": 0.6}


def kept(action_space: str, scp: dict[str, float], rng=None) -> set[str]:
    return {dof for dof, scale in action_scales(action_space, scp, rng).items() if scale}


def test_known_answers():
    assert action_scales("full", SCP) == {"a": 1, "b": 1, "c": 1, "d": 1}
    assert action_scales("truncated", SCP) == {"a": 0, "b": 1, "c": 0, "d": 1}
    assert action_scales("inverse", SCP) == {"a": 1, "b": 0, "c": 1, "d": 0}
    assert action_scales("adapted", SCP) == pytest.approx({"a": 0.2, "b": 1.0, "c": 0.0, "d": 0.8})


def test_adapted_ends_exactly_at_one_and_zero_and_is_whole_where_all_are_equal():
    scales = action_scales("adapted", {"a": 0.1, "b": 0.3, "c": 0.7})
    assert scales["a"] == 1.0 and scales["c"] == 0.0
    assert set(action_scales("adapted", {"a": 0.4, "b": 0.4}).values()) == {1.0}


def test_ties_go_by_the_order_of_the_actions_and_odd_numbers_keep_the_larger_half():
    assert kept("truncated", {"a": 1.0, "b": 1.0, "c": 1.0}) == {"a", "b"}
    assert kept("inverse", {"a": 1.0, "b": 1.0, "c": 1.0}) == {"b", "c"}
    assert len(kept("random-half", {"a": 1.0, "b": 1.0, "c": 1.0}, np.random.default_rng(0))) == 2


def test_a_random_half_is_the_same_for_the_same_run_and_different_for_others(default_config):
    scp = dict.fromkeys("abcdefgh", 0.5)
    draws = [
        tuple(scales_of_run(default_config, scp, "random-half", seed).values())
        for seed in range(12)
    ]
    assert draws == [
        tuple(scales_of_run(default_config, scp, "random-half", seed).values())
        for seed in range(12)
    ]
    assert all(sum(draw) == 4 for draw in draws) and len(set(draws)) > 6
    with pytest.raises(ValueError, match="generator"):
        action_scales("random-half", scp)


def test_all_spaces_keep_the_order_of_the_actions():
    for name in ACTION_SPACES:
        assert list(action_scales(name, SCP, np.random.default_rng(0))) == list(SCP)
    with pytest.raises(ValueError, match="truncated"):
        action_scales("shortened", SCP)


class Echo(gym.Env):
    """Not Flatland: it shows the action that it was given."""

    observation_space = spaces.Box(-1, 1, (3,), np.float32)
    action_space = spaces.Box(-1, 1, (3,), np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(3, np.float32), {}

    def step(self, action):
        return np.asarray(action, np.float32), 0.0, False, False, {}


def test_scaled_actions_arrive_at_a_foreign_environment():
    env = ScaledAction(Echo(), [0.5, 0.0, 1.0])
    env.reset(seed=0)
    assert env.action_space == spaces.Box(-1, 1, (2,), np.float32)
    assert env.step(np.array([1.0, -0.25], np.float32))[0].tolist() == [0.5, 0.0, -0.25]
    assert env.step(np.array([4.0, -3.0], np.float32))[0].tolist() == [0.5, 0.0, -1.0]


def test_the_vector_wrapper_agrees_with_the_single_one():
    many = ScaledActions(SyncVectorEnv([Echo, Echo]), [0.5, 0.0, 1.0])
    many.reset(seed=0)
    assert many.single_action_space.shape == (2,) and many.action_space.shape == (2, 2)
    assert many.step(np.array([[1.0, -0.25], [0.2, 7.0]], np.float32))[0] == pytest.approx(
        np.array([[0.5, 0, -0.25], [0.1, 0, 1.0]])
    )


@pytest.mark.parametrize(
    ("scales", "message"),
    [
        ([1.0, 1.0], "shape"),
        ([1.0, 2.0, 0.0], r"\[0, 1\]"),
        ([-0.1, 1, 1], r"\[0, 1\]"),
        ([0, 0, 0], "nothing is left"),
    ],
)
def test_senseless_scales_are_refused(scales, message):
    with pytest.raises(ValueError, match=message):
        ScaledAction(Echo(), scales)


def test_actions_of_another_range_are_refused():
    env = Echo()
    env.action_space = spaces.Box(-2, 2, (3,), np.float32)
    with pytest.raises(ValueError, match="rescale"):
        ScaledAction(env, [1, 1, 1])


def table(**changes) -> pd.DataFrame:
    rows = pd.DataFrame(
        dict(world="w", agent="x", length=50, dof=list("abc"), threshold=0.0, scp=[0.5, 0.7, 1.0])
    )
    return rows.assign(**changes)


def test_scps_come_in_the_order_of_the_actions_and_only_from_the_rows_asked_for():
    frame = pd.concat(
        [
            table(),
            table(world="v", scp=0.1),
            table(agent="y", scp=0.1),
            table(length=10, scp=0.1),
            table(threshold=1.0, scp=0.1),
        ]
    )
    assert scp_of(frame, ["c", "a", "b"], "w", "x", 50) == {"c": 1.0, "a": 0.5, "b": 0.7}


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (table()[:2], "no row for c"),
        (table(threshold=1.0), "no row for a, b, c"),
        (table(agent="y"), "no row for a, b, c"),
        (pd.concat([table(), table()[1:2]]), "more than one row for b"),
        (table(scp=[0.5, float("nan"), 1.0]), "SCP of b"),
        (table(scp=[0.5, 0.6, 1.1]), "SCP of c"),
    ],
)
def test_a_table_that_lacks_something_is_refused(frame, message):
    with pytest.raises(ScpError, match=message):
        scp_of(frame, list("abc"), "w", "x", 50)
