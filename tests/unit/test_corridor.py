"""worlds/corridor.py: known answers."""

from __future__ import annotations

import numpy as np
import pytest
from sensory_commutativity.helpers import started

from sensory_commutativity.worlds.corridor import Corridor


def end(world: Corridor, *directions: float) -> list[float]:
    """Places of agent and box after some moves from the start."""
    started(world)
    for direction in directions:
        world.step(np.array([direction, 0.0]))
    return world.observe()[:2].tolist()


@pytest.mark.parametrize(
    ("corridor", "directions", "expected"),
    [
        ({}, (1, 1, -1), [1, -1]),
        ({}, (0, 0), [0, -1]),
        ({}, (0.01, 0.9, -0.2), [1, -1]),  # whole places, the sign of the action
        ({}, (-1, -1, -1), [-3, -1]),  # nothing on the left
        ({"wall": 2}, (1, 1, 1, 1), [2, -1]),
        ({"wall": 2}, (1, 1, 1, 1, -1), [1, -1]),  # what the wall swallowed is lost
        ({"wall": 0}, (1,), [0, -1]),
        ({"box": 1}, (1,), [1, 2]),  # pushed
        ({"box": 1}, (1, 1, 1), [3, 4]),
        ({"box": 2}, (1,), [1, 2]),  # not yet reached
        ({"box": 1}, (1, -1, -1), [-1, 2]),  # not pulled
        ({"box": 1, "wall": 2}, (1, 1, 1), [1, 2]),  # stuck against the wall
        ({"box": 1, "wall": 1}, (1,), [0, 1]),
    ],
    ids=str,
)
def test_moves(corridor, directions, expected):
    assert end(Corridor(**corridor), *directions) == expected


def test_the_eyelid_moves_nothing():
    world = started(Corridor(box=1))
    for action in (1.0, 0.3, -0.5, 0.0, 0.1):  # by quarters, the sign of the action
        world.step(np.array([0.0, action]))
    assert world.observe().tolist() == [0, 1, 1.5]
    assert [dof.displaces for dof in world.dofs] == [True, False]


def test_move_and_eyelid_in_one_action():
    world = started(Corridor())
    world.step(np.array([-1.0, -1.0]))
    assert world.observe().tolist() == [-1, -1, 0.75]


def test_reset_puts_everything_back():
    world = Corridor(box=1)
    end(world, 1, 1, 1)
    assert started(world).observe().tolist() == [0, 1, 1]


def test_instances_share_nothing():
    one, other = started(Corridor()), started(Corridor())
    one.step(np.array([1.0, 0.0]))
    assert other.observe()[0] == 0
