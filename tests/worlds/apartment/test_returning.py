"""Going back after a push: by odometry, and by sight."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity import make_apartment
from sensory_commutativity.worlds.apartment.returning import CLOSE, Wheels, drive_back, turn_to_view


@pytest.fixture(scope="module")
def fetch():
    world = make_apartment("fetch", "rs-stand-in", image_size=64)
    world.reset(np.random.default_rng(0))
    return world, world.snapshot()


def offset(world, start: np.ndarray) -> tuple[float, float]:
    moved = world.simulation.base() - start
    return float(np.hypot(*moved[:2])), abs(float(np.angle(np.exp(1j * moved[2]))))


def move(world, forward: float, turn: float) -> None:
    wheels = Wheels(world)
    wheels.move(forward, turn)
    wheels.stop()


def test_wheels_move_by_what_is_asked_for(fetch) -> None:
    world, snapshot = fetch
    for forward, turn in ((0.03, 0.0), (0.0, 0.2)):
        world.restore(snapshot)
        start = world.simulation.base()
        move(world, forward, turn)
        assert offset(world, start) == pytest.approx((forward, turn), abs=0.005)


@pytest.mark.parametrize("away", [[(-0.05, 0.1), (0.0, 0.3)], [(0.0, -0.5), (-0.08, 0.0)]])
def test_it_drives_back_to_where_it_started(fetch, away) -> None:
    world, snapshot = fetch
    world.restore(snapshot)
    start = world.simulation.base()
    for forward, turn in away:
        move(world, forward, turn)
    assert max(offset(world, start)) > 0.05
    drive_back(world, start)
    distance, turned = offset(world, start)
    assert distance < 2 * CLOSE[0] and turned < 2 * CLOSE[1]


def test_it_turns_until_it_sees_the_start_again(fetch) -> None:
    world, snapshot = fetch
    world.restore(snapshot)
    start, view = world.simulation.base(), world.observe()
    move(world, 0.0, 0.25)
    turn_to_view(world, view)
    assert offset(world, start)[1] < 0.03


def test_a_robot_without_wheels_stays() -> None:
    class Fixed:
        robot = type("R", (), {"description": type("D", (), {"drive": None})})

    drive_back(Fixed(), np.zeros(3))
    turn_to_view(Fixed(), np.zeros((1, 8, 8, 3), np.uint8))
