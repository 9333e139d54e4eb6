"""worlds/flatland/chipmunk.py: Chipmunk called by address does what pymunk's public attributes say."""

from __future__ import annotations

import numpy as np
import pymunk
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensory_commutativity.worlds.flatland import chipmunk

numbers = st.floats(-1e3, 1e3, allow_subnormal=False)
six = st.tuples(*[numbers] * 6)


def body(state=(0.0,) * 6, space: pymunk.Space | None = None) -> pymunk.Body:
    made = pymunk.Body(2.0, 3.0)
    x, y, angle, vx, vy, w = state
    made.position, made.angle, made.velocity, made.angular_velocity = (x, y), angle, (vx, vy), w
    if space is not None:
        shape = pymunk.Circle(made, 5.0)
        space.add(made, shape)
    return made


def read(of: pymunk.Body, channel: chipmunk.Channel) -> np.ndarray:
    channel.cursor[0] = 0
    chipmunk.READ_BODY(chipmunk.body_address(of), channel.address)
    return channel.values[: channel.cursor[0]].copy()


def write(of: pymunk.Body, channel: chipmunk.Channel, values) -> None:
    channel.values[: len(values)] = values
    channel.cursor[0] = 0
    chipmunk.WRITE_BODY(chipmunk.body_address(of), channel.address)


@given(six)
def test_pose_and_velocity_are_read(state):
    of = body(state)
    found = read(of, chipmunk.Channel(chipmunk.POSE_AND_VELOCITY))
    assert (
        found.tolist() == [*of.position, of.angle, *of.velocity, of.angular_velocity] == list(state)
    )


@given(six, st.tuples(*[numbers] * 5))
def test_position_force_and_torque_are_written(state, values):
    to = body(state)
    write(to, chipmunk.Channel(chipmunk.POSITION_AND_FORCE), values)
    assert [*to.position, *to.force, to.torque] == list(values)
    assert [to.angle, *to.velocity, to.angular_velocity] == list(state[2:])  # and nothing else


@given(six, st.tuples(numbers, numbers))
def test_velocity_is_written(state, values):
    to = body(state)
    write(to, chipmunk.Channel(chipmunk.VELOCITY), values)
    assert tuple(to.velocity) == values
    assert [*to.position, to.angle, to.angular_velocity] == [*state[:3], state[5]]


@given(st.tuples(*[numbers] * 5))
def test_what_is_written_is_read_back(values):
    of, channel = body(), chipmunk.Channel(chipmunk.POSITION_AND_FORCE)
    write(of, channel, values)
    channel.values[:] = 0
    assert read(of, channel).tolist() == list(values)


def test_many_reads_never_move_the_array():
    channel, of = chipmunk.Channel(chipmunk.POSE_AND_VELOCITY), body((1, 2, 3, 4, 5, 6))
    address = channel.values.ctypes.data
    for _ in range(1000):
        assert read(of, channel).tolist() == [1, 2, 3, 4, 5, 6]
    assert channel.values.ctypes.data == address
    assert len(channel.values) >= 9  # as many numbers as a body has


def test_the_cursor_counts_what_was_read():
    channel = chipmunk.Channel(chipmunk.POSE_AND_VELOCITY)
    one, other = body((1, 2, 3, 4, 5, 6)), body((7, 8, 9, 10, 11, 12))
    channel.cursor[0] = 0
    for of in (one, other):
        chipmunk.READ_BODY(chipmunk.body_address(of), channel.address)
    assert channel.cursor[0] == 12
    assert channel.values[:12].tolist() == list(range(1, 13))


def test_channels_are_their_own():
    first, second = (chipmunk.Channel(chipmunk.POSE_AND_VELOCITY) for _ in range(2))
    assert first.address != second.address
    before = second.cursor[0]
    read(body((1, 2, 3, 4, 5, 6)), first)
    assert not second.values.any() and second.cursor[0] == before


def crowd(rng: np.random.Generator) -> tuple[pymunk.Space, list[pymunk.Body]]:
    """A space with colliding discs and a joint."""
    space = pymunk.Space()
    space.damping, space.gravity = 0.9, (0, -3)
    bodies = [body(rng.uniform(-10, 10, 6), space) for _ in range(8)]
    space.add(pymunk.PivotJoint(bodies[0], bodies[1], (1, 0), (0, 1)))
    return space, bodies


@pytest.mark.parametrize("seed", range(3))
def test_a_step_is_pymunk_s_step(seed):
    (space, bodies), (public, public_bodies) = (
        crowd(np.random.default_rng(seed)) for _ in range(2)
    )
    for _ in range(50):
        chipmunk.STEP(chipmunk.space_address(space), 0.25)
        public.step(0.25)
    for ours, theirs in zip(bodies, public_bodies, strict=True):
        assert (*ours.position, ours.angle, *ours.velocity, ours.angular_velocity) == (
            *theirs.position, theirs.angle, *theirs.velocity, theirs.angular_velocity,
        )  # fmt: skip
    assert not np.allclose(
        [b.position for b in bodies], [b.position for b in crowd(np.random.default_rng(seed))[1]]
    )


def test_a_written_force_acts_in_the_next_step():
    space = pymunk.Space()
    of = body(space=space)
    write(of, chipmunk.Channel(chipmunk.POSITION_AND_FORCE), (0, 0, 8.0, -4.0, 6.0))
    chipmunk.STEP(chipmunk.space_address(space), 0.5)
    assert tuple(of.velocity) == pytest.approx((2.0, -1.0))  # mass 2, half a step
    assert of.angular_velocity == pytest.approx(1.0)  # moment 3
    assert tuple(of.force) == (0, 0) and of.torque == 0  # and in no later one


def test_addresses_are_those_of_different_things():
    space, bodies = crowd(np.random.default_rng(0))
    addresses = [chipmunk.body_address(b) for b in bodies] + [chipmunk.space_address(space)]
    assert len(set(addresses)) == 9
    assert all(isinstance(address, int) and address > 0 for address in addresses)
