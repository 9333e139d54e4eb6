"""worlds/flatland/control.py: from commands to velocities, on a grid and with a short leash."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensory_commutativity.helpers import EMPTY, FREE_SPACE, drive, enter, started

from sensory_commutativity.scp.sequences import compose, no_op
from sensory_commutativity.worlds.flatland import control
from sensory_commutativity.worlds.flatland.agent import N_LINKS
from sensory_commutativity.worlds.flatland.control import (
    CORRECTION,
    DT,
    EYELID,
    GRID,
    HEAD,
    INNER,
    SLACK,
    SUBSTEPS,
    TARGET,
    TIME,
)
from sensory_commutativity.worlds.flatland.room import Room
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

# ---- small functions -------------------------------------------------------------------------------------------------------


@given(st.floats(-1e3, 1e3))
def test_the_grid_is_fine(value):
    rounded = control._on_grid(value)
    assert abs(rounded - value) <= 0.5 / GRID
    assert (rounded * GRID).is_integer()
    assert control._on_grid(rounded) == rounded


@given(st.lists(st.floats(-8, 8), min_size=2, max_size=200), st.randoms(use_true_random=False))
def test_sums_on_the_grid_do_not_depend_on_their_order(values, random):
    values = [control._on_grid(value) for value in values]
    total = sum(values, 400.0)
    random.shuffle(values)
    assert sum(values, 400.0) == total


@given(st.floats(-10, 10), st.floats(-10, 0), st.floats(0, 10))
def test_clip(value, low, high):
    assert control._clip(value, low, high) == np.clip(value, low, high)


@pytest.mark.parametrize(("value", "expected"), [(5.0, 5.0), (5.4, 5.4), (7.0, 5.5), (-1.0, 4.5)])
def test_within(value, expected):
    assert control._within(value, 5.0, 0.5) == expected


@pytest.mark.parametrize(
    ("error", "command", "expected"),
    [
        (0.0, 0.0, 0.0),
        (2.0, 2.0, 2.0 / DT),  # what was commanded, in one sub-step
        (2.1, 2.0, 2.1 / DT),  # a small lag is made up at once
        (
            100.0,
            2.0,
            2.0 / DT + CORRECTION * 8.0,
        ),  # a large one no faster than half the top speed more
        (-100.0, 0.0, -CORRECTION * 8.0),
    ],
)
def test_velocity(error, command, expected):
    assert control._velocity(error, command, 8.0) == pytest.approx(expected)


def test_four_sub_steps_make_a_step():
    assert SUBSTEPS * DT == 1.0
    assert math.log2(GRID).is_integer()
    assert len(SLACK) == 7


def test_the_inner_state_has_a_place_for_everything():
    world = started(FlatlandWorld(), 2)
    inner = world.inner
    assert inner.shape == (INNER,)
    assert np.array_equal(inner[TARGET][:3], world.situation.links[0])
    assert np.array_equal(inner[TARGET][3:], world.agent.rest_angles)
    assert (inner[HEAD], inner[EYELID], inner[TIME]) == (0.0, 1.0, 0.0)
    inner[:] = 7  # a copy
    assert world.inner[TIME] == 0
    world.play(np.zeros((5, 8)))
    assert world.inner[TIME] == 5


# ---- free motion -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [1.0, 0.3, -0.77])
def test_the_base_runs_at_its_speed_and_stops_at_once(value):
    world = enter(FREE_SPACE, 0, 0, 0.0)
    places = [0.0]
    for action in compose(drive("base-longitudinal", value, 10), no_op(4, 8)):
        world.step(action)
        places.append(world.poses()[0, 0])
    steps = np.diff(places)
    assert steps[1:10] == pytest.approx(
        np.full(9, 8 * value), abs=1e-4
    )  # the first and the last carry a sub-step's delay
    assert places[-1] == pytest.approx(80 * value, abs=1e-4)
    assert steps[11:] == pytest.approx(np.zeros(3), abs=1e-9)


def test_two_steps_of_rest_are_enough():
    world = started(FlatlandWorld(FREE_SPACE), 1)
    rng = np.random.default_rng(1)
    for _ in range(20):
        world.play(compose(rng.uniform(-1, 1, (5, 8)), no_op(2, 8)))
        at_rest = world.poses()
        world.play(no_op(5, 8))
        assert np.allclose(world.poses(), at_rest, atol=1e-9)


def test_a_command_acts_in_its_own_step():
    world = enter(FREE_SPACE, 0, 0, 0.0)
    world.step(drive("base-longitudinal", 1.0, 1)[0])
    assert world.poses()[0, 0] == pytest.approx(6.0, abs=1e-4)  # three sub-steps of four
    assert world.inner[0] == pytest.approx(8.0, abs=1e-5)  # the target is there


@pytest.mark.parametrize("seed", range(3))
def test_targets_are_reached_in_free_space(seed):
    world = started(FlatlandWorld(FREE_SPACE), seed)
    world.play(compose(np.random.default_rng(seed).uniform(-1, 1, (50, 8)), no_op(3, 8)))
    poses, inner = world.poses(), world.inner
    joints = [
        poses[1, 2] - poses[0, 2],
        poses[2, 2] - poses[1, 2],
        poses[3, 2] - poses[0, 2],
        poses[4, 2] - poses[3, 2],
    ]
    assert np.allclose([*poses[0], *joints], inner[TARGET], atol=1e-9)


# ---- contact ---------------------------------------------------------------------------------------------------------------


def test_a_target_waits_for_what_is_blocked():
    world = enter(EMPTY, 300, 150, -math.pi / 2)
    for action in drive("base-longitudinal", 1.0, 60):
        world.step(action)
        ahead = abs(world.inner[1] - world.poses()[0, 1])
        assert (
            ahead <= SLACK[1] + 2 * 8.0 * DT + 1e-6
        )  # the slack, the command of the last sub-step, and one that is still to be carried out
    assert ahead > SLACK[1]


def test_a_blocked_base_turns_back_at_once():
    """It leaves the wall with the first command: 8 units less the slack and a sub-step's delay."""
    world = enter(EMPTY, 300, 150, -math.pi / 2)
    world.play(drive("base-longitudinal", 1.0, 200))
    at_wall = world.poses()[0, 1]
    world.play(compose(drive("base-longitudinal", -1.0, 1), no_op(2, 8)))
    assert 5.0 < world.poses()[0, 1] - at_wall < 9.0


BALL = {"vertices": 0, "radius": 20.0, "kind": 1, "colour": (255, 0, 0)}


def test_a_movable_thing_is_pushed_and_comes_to_rest():
    world = enter(FREE_SPACE, 0, 0, 0.0, [{**BALL, "pose": (70, 0, 0)}], None)
    world.play(
        drive("base-longitudinal", 1.0, 15)
    )  # to 120: the ball, 45 ahead of the base, to 165 at least
    pushed = world.poses()[N_LINKS, 0]
    assert pushed > 160
    places = []
    for _ in range(12):
        world.play(no_op(10, 8))
        places.append(world.poses()[N_LINKS, 0])
    coasted = np.diff([pushed, *places])
    assert coasted[0] > 0
    assert all(later <= earlier for earlier, later in pairwise(coasted))
    assert coasted[-1] < 0.01
    assert abs(world.poses()[0, 0] - 120) < 1  # the agent stays


def test_a_fixed_thing_does_not_move():
    world = enter(FREE_SPACE, 0, 0, 0.0, [{**BALL, "kind": 0, "pose": (100, 0, 0)}])
    world.play(drive("base-longitudinal", 1.0, 30))
    assert world.poses()[N_LINKS].tolist() == [100, 0, 0]
    assert world.poses()[0, 0] == pytest.approx(100 - 20 - 25, abs=3)


def test_a_pushed_agent_comes_back_to_where_it_should_be():
    """Things that move by themselves push it about; it holds its pose within the slack once they are gone."""
    world = started(
        FlatlandWorld(Room(things=12, width=420.0, height=420.0, start_margin=150.0)), 4
    )
    for _ in range(20):
        world.play(no_op(10, 8))
        assert np.abs(world.inner[:2] - world.poses()[0, :2]).max() <= SLACK[0] + 1e-6


def test_the_agent_does_not_collide_with_itself():
    world = enter(FREE_SPACE, 0, 0, 0.0)
    world.play(
        compose(drive("left-shoulder", -1.0, 25), no_op(3, 8))
    )  # a full turn, across body and other arm
    turned = world.poses()[1, 2] - world.agent.rest_angles[0]
    assert turned == pytest.approx(-6.25, abs=1e-4)
    assert world.poses()[0] == pytest.approx([0, 0, 0], abs=1e-6)
