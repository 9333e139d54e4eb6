"""worlds/flatland/control.py: from commands to velocities, on a grid, with bounded targets."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensory_commutativity.scp.sequences import compose, no_op
from sensory_commutativity.worlds.flatland import control
from sensory_commutativity.worlds.flatland.agent import N_LINKS
from sensory_commutativity.worlds.flatland.control import (
    DT,
    EYELID,
    GRID,
    HEAD,
    MAX_CORRECTION,
    MAX_TRACKING_ERROR,
    STATE_SIZE,
    TARGET,
    TIME,
)
from sensory_commutativity.worlds.flatland.room import FIXED, MOVABLE, Room
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import EMPTY, FREE_SPACE, drive, make_world, reset_world

BALL = {"vertices": 0, "radius": 20.0, "colour": (255, 0, 0)}

# ---- small functions -----------------------------------------------------------------------------


@given(st.floats(-1e3, 1e3))
def test_rounding_to_the_grid(value):
    rounded = control._round_to_grid(value)
    assert abs(rounded - value) <= 0.5 / GRID
    assert (rounded * GRID).is_integer()
    assert control._round_to_grid(rounded) == rounded


@given(st.lists(st.floats(-8, 8), min_size=2, max_size=200), st.randoms(use_true_random=False))
def test_sums_on_the_grid_do_not_depend_on_the_order(values, random):
    values = [control._round_to_grid(value) for value in values]
    total = sum(values, 400.0)
    random.shuffle(values)
    assert sum(values, 400.0) == total


def test_clipping():
    for value, expected in [(5.0, 5.0), (5.4, 5.4), (7.0, 5.5), (-1.0, 4.5)]:
        assert control._clip_around(value, 5.0, 0.5) == expected
        assert control._clip(value, 4.5, 5.5) == expected


def test_tracking_velocity():
    correction = MAX_CORRECTION * 8.0
    for error, command, expected in [
        (0.0, 0.0, 0.0),
        (2.0, 2.0, 2.0 / DT),  # the command, in one sub-step
        (2.1, 2.0, 2.1 / DT),  # a small lag is corrected at once
        (100.0, 2.0, 2.0 / DT + correction),  # a large one at limited velocity
        (-100.0, 0.0, -correction),
    ]:
        velocity = control._tracking_velocity(error, command, 8.0)
        assert velocity == pytest.approx(expected), (error, command)


def test_controller_state():
    world = reset_world(FlatlandWorld(), 2)
    state = world.controller_state
    assert state.shape == (STATE_SIZE,)
    assert np.array_equal(state[TARGET][:3], world.situation.links[0])
    assert np.array_equal(state[TARGET][3:], world.agent.rest_angles)
    assert (state[HEAD], state[EYELID], state[TIME]) == (0.0, 1.0, 0.0)
    state[:] = 7  # a copy
    assert world.controller_state[TIME] == 0
    world.play(np.zeros((5, 8)))
    assert world.controller_state[TIME] == 5


# ---- free motion ---------------------------------------------------------------------------------


def test_base_runs_at_its_speed_and_stops_at_once():
    for value in (1.0, 0.3, -0.77):
        world = make_world(FREE_SPACE, 0, 0, 0.0)
        xs = [0.0]
        for action in compose(drive("base-longitudinal", value, 10), no_op(4, 8)):
            world.step(action)
            xs.append(world.poses()[0, 0])
        steps = np.diff(xs)  # the first and the last are delayed by a sub-step
        assert steps[1:10] == pytest.approx(np.full(9, 8 * value), abs=1e-4)
        assert xs[-1] == pytest.approx(80 * value, abs=1e-4)
        assert steps[11:] == pytest.approx(np.zeros(3), abs=1e-9)


def test_a_command_acts_in_its_own_step():
    world = make_world(FREE_SPACE, 0, 0, 0.0)
    world.step(drive("base-longitudinal", 1.0, 1)[0])
    assert world.poses()[0, 0] == pytest.approx(6.0, abs=1e-4)  # three sub-steps of four
    assert world.controller_state[0] == pytest.approx(8.0, abs=1e-5)  # the target has arrived


def test_two_rest_steps_are_enough():
    world = reset_world(FlatlandWorld(FREE_SPACE), 1)
    rng = np.random.default_rng(1)
    for _ in range(20):
        world.play(compose(rng.uniform(-1, 1, (5, 8)), no_op(2, 8)))
        at_rest = world.poses()
        world.play(no_op(5, 8))
        assert np.allclose(world.poses(), at_rest, atol=1e-9)


def test_targets_are_reached_in_free_space():
    for seed in range(3):
        world = reset_world(FlatlandWorld(FREE_SPACE), seed)
        world.play(compose(np.random.default_rng(seed).uniform(-1, 1, (50, 8)), no_op(3, 8)))
        poses = world.poses()
        joints = poses[1:5, 2] - poses[[0, 1, 0, 3], 2]
        assert np.allclose([*poses[0], *joints], world.controller_state[TARGET], atol=1e-9)


# ---- contact -------------------------------------------------------------------------------------


def test_targets_of_blocked_bodies_wait():
    world = make_world(EMPTY, 300, 150, -math.pi / 2)
    for action in drive("base-longitudinal", 1.0, 60):
        world.step(action)
        error = abs(world.controller_state[1] - world.poses()[0, 1])
        # the maximum, the command of the last sub-step, and one that is still to be executed
        assert error <= MAX_TRACKING_ERROR[1] + 2 * 8.0 * DT + 1e-6
    assert error > MAX_TRACKING_ERROR[1]


def test_a_blocked_base_reverses_at_once():
    """With the first command it moves 8 units less the tracking error and a sub-step's delay."""
    world = make_world(EMPTY, 300, 150, -math.pi / 2)
    world.play(drive("base-longitudinal", 1.0, 200))
    blocked_y = world.poses()[0, 1]
    world.play(compose(drive("base-longitudinal", -1.0, 1), no_op(2, 8)))
    assert 5.0 < world.poses()[0, 1] - blocked_y < 9.0


def test_movable_objects_are_pushed_and_come_to_rest():
    ball = {**BALL, "kind": MOVABLE, "pose": (70, 0, 0)}
    world = make_world(FREE_SPACE, 0, 0, 0.0, [ball])
    world.play(drive("base-longitudinal", 1.0, 15))  # to 120, with the ball 45 ahead
    xs = [world.poses()[N_LINKS, 0]]
    assert xs[0] > 160
    for _ in range(12):
        world.play(no_op(10, 8))
        xs.append(world.poses()[N_LINKS, 0])
    coasted = np.diff(xs)
    assert coasted[0] > 0
    assert all(later <= earlier for earlier, later in pairwise(coasted))
    assert coasted[-1] < 0.01
    assert abs(world.poses()[0, 0] - 120) < 1  # the agent stays


def test_fixed_objects_do_not_move():
    ball = {**BALL, "kind": FIXED, "pose": (100, 0, 0)}
    world = make_world(FREE_SPACE, 0, 0, 0.0, [ball])
    world.play(drive("base-longitudinal", 1.0, 30))
    assert world.poses()[N_LINKS].tolist() == [100, 0, 0]
    assert world.poses()[0, 0] == pytest.approx(100 - 20 - 25, abs=3)


def test_a_pushed_agent_holds_its_position():
    """Moving objects push it around, and it returns to within the maximum tracking error."""
    room = Room(objects=12, width=420.0, height=420.0, start_margin=150.0)
    world = reset_world(FlatlandWorld(room), 4)
    for _ in range(20):
        world.play(no_op(10, 8))
        error = np.abs(world.controller_state[:2] - world.poses()[0, :2]).max()
        assert error <= MAX_TRACKING_ERROR[0] + 1e-6


def test_the_agent_does_not_collide_with_itself():
    world = make_world(FREE_SPACE, 0, 0, 0.0)
    # a full turn, across the base and the other arm
    world.play(compose(drive("left-shoulder", -1.0, 25), no_op(3, 8)))
    turn = world.poses()[1, 2] - world.agent.rest_angles[0]
    assert turn == pytest.approx(-6.25, abs=1e-4)
    assert world.poses()[0] == pytest.approx([0, 0, 0], abs=1e-6)
