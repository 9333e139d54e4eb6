"""worlds/flatland/chipmunk.py: Chipmunk called by address against pymunk's public interface."""

from __future__ import annotations

import numpy as np
import pymunk
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensory_commutativity.worlds.flatland.chipmunk import (
    ENGINE,
    POSE_AND_VELOCITY,
    POSITION_AND_FORCE,
    VELOCITY,
    Channel,
    body_address,
    space_address,
)

numbers = st.floats(-1e3, 1e3, allow_subnormal=False)


def numbers_tuple(n: int) -> st.SearchStrategy:
    return st.tuples(*[numbers] * n)


def make_body(state=(0.0,) * 6, space: pymunk.Space | None = None) -> pymunk.Body:
    body = pymunk.Body(2.0, 3.0)
    x, y, angle, vx, vy, w = state
    body.position, body.angle, body.velocity, body.angular_velocity = (x, y), angle, (vx, vy), w
    if space is not None:
        space.add(body, pymunk.Circle(body, 5.0))
    return body


def read(body: pymunk.Body, channel: Channel) -> list[float]:
    channel.cursor[0] = 0
    ENGINE.read_body(body_address(body), channel.address)
    return channel.values[: channel.cursor[0]].tolist()


def write(body: pymunk.Body, channel: Channel, values) -> None:
    channel.values[: len(values)] = values
    channel.cursor[0] = 0
    ENGINE.write_body(body_address(body), channel.address)


@given(numbers_tuple(6))
def test_pose_and_velocity_are_read(state):
    body = make_body(state)
    public = [*body.position, body.angle, *body.velocity, body.angular_velocity]
    assert read(body, Channel(POSE_AND_VELOCITY)) == public == list(state)


@given(numbers_tuple(6), numbers_tuple(5))
def test_position_force_and_torque_are_written_and_nothing_else(state, values):
    body, channel = make_body(state), Channel(POSITION_AND_FORCE)
    write(body, channel, values)
    assert [*body.position, *body.force, body.torque] == list(values)
    assert [body.angle, *body.velocity, body.angular_velocity] == list(state[2:])
    channel.values[:] = 0
    assert read(body, channel) == list(values)


@given(numbers_tuple(6), numbers_tuple(2))
def test_velocity_is_written_and_nothing_else(state, values):
    body = make_body(state)
    write(body, Channel(VELOCITY), values)
    assert tuple(body.velocity) == values
    assert [*body.position, body.angle, body.angular_velocity] == [*state[:3], state[5]]


def test_reads_never_reallocate_the_array():
    channel, body = Channel(POSE_AND_VELOCITY), make_body((1, 2, 3, 4, 5, 6))
    address = channel.values.ctypes.data
    for _ in range(1000):
        assert read(body, channel) == [1, 2, 3, 4, 5, 6]
    assert channel.values.ctypes.data == address
    assert len(channel.values) >= 9  # as many numbers as a body has


def test_cursor_counts_the_numbers_of_several_reads():
    channel = Channel(POSE_AND_VELOCITY)
    bodies = [make_body((1, 2, 3, 4, 5, 6)), make_body((7, 8, 9, 10, 11, 12))]
    channel.cursor[0] = 0
    for body in bodies:
        ENGINE.read_body(body_address(body), channel.address)
    assert channel.cursor[0] == 12
    assert channel.values[:12].tolist() == list(range(1, 13))


def test_channels_are_independent():
    first, second = Channel(POSE_AND_VELOCITY), Channel(POSE_AND_VELOCITY)
    assert first.address != second.address
    before = second.cursor[0]
    read(make_body((1, 2, 3, 4, 5, 6)), first)
    assert not second.values.any() and second.cursor[0] == before


def make_crowd(seed: int) -> tuple[pymunk.Space, list[pymunk.Body]]:
    """A space with colliding discs and a joint."""
    rng = np.random.default_rng(seed)
    space = pymunk.Space()
    space.damping, space.gravity = 0.9, (0, -3)
    bodies = [make_body(rng.uniform(-10, 10, 6), space) for _ in range(8)]
    space.add(pymunk.PivotJoint(bodies[0], bodies[1], (1, 0), (0, 1)))
    return space, bodies


def test_a_step_equals_pymunk_s_step():
    for seed in range(3):
        (space, bodies), (public_space, public_bodies) = make_crowd(seed), make_crowd(seed)
        starts = np.array([body.position for body in bodies])
        addresses = [body_address(body) for body in bodies] + [space_address(space)]
        assert len(set(addresses)) == 9
        for _ in range(50):
            ENGINE.step(space_address(space), 0.25)
            public_space.step(0.25)
        for ours, theirs in zip(bodies, public_bodies, strict=True):
            assert (*ours.position, ours.angle, *ours.velocity, ours.angular_velocity) == (
                *theirs.position, theirs.angle, *theirs.velocity, theirs.angular_velocity,
            )  # fmt: skip
        assert not np.allclose([body.position for body in bodies], starts)


def test_a_written_force_acts_in_the_next_step_only():
    space = pymunk.Space()
    body = make_body(space=space)
    write(body, Channel(POSITION_AND_FORCE), (0, 0, 8.0, -4.0, 6.0))
    ENGINE.step(space_address(space), 0.5)
    assert tuple(body.velocity) == pytest.approx((2.0, -1.0))  # mass 2, half a step
    assert body.angular_velocity == pytest.approx(1.0)  # moment 3
    assert tuple(body.force) == (0, 0) and body.torque == 0
