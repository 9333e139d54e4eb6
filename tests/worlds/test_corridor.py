"""worlds/corridor.py: known answers."""

from __future__ import annotations

import numpy as np

from sensory_commutativity.worlds.corridor import Corridor
from tests.helpers import reset_world


def test_moves():
    for corridor, directions, expected in [
        ({}, (1, 1, -1), [1, -1]),
        ({}, (0, 0), [0, -1]),
        ({}, (0.01, 0.9, -0.2), [1, -1]),  # whole cells: only the sign matters
        ({}, (-1, -1, -1), [-3, -1]),  # nothing on the left
        ({"wall": 2}, (1, 1, 1, 1), [2, -1]),
        ({"wall": 2}, (1, 1, 1, 1, -1), [1, -1]),  # blocked motion is lost
        ({"wall": 0}, (1,), [0, -1]),
        ({"box": 1}, (1,), [1, 2]),  # pushed
        ({"box": 1}, (1, 1, 1), [3, 4]),
        ({"box": 2}, (1,), [1, 2]),  # not reached
        ({"box": 1}, (1, -1, -1), [-1, 2]),  # not pulled
        ({"box": 1, "wall": 2}, (1, 1, 1), [1, 2]),  # against the wall
        ({"box": 1, "wall": 1}, (1,), [0, 1]),
    ]:
        world = reset_world(Corridor(**corridor))
        for direction in directions:
            world.step(np.array([direction, 0.0]))
        assert world.observe()[:2].tolist() == expected, (corridor, directions)
        start = [0, corridor.get("box", -1), 1]
        assert reset_world(world).observe().tolist() == start


def test_the_eyelid_moves_by_quarters_and_displaces_nothing():
    world = reset_world(Corridor(box=1))
    for action in (1.0, 0.3, -0.5, 0.0, 0.1):  # only the sign matters
        world.step(np.array([0.0, action]))
    assert world.observe().tolist() == [0, 1, 1.5]
    world.step(np.array([-1.0, -1.0]))
    assert world.observe().tolist() == [-1, 1, 1.25]
    assert [dof.displaces for dof in world.dofs] == [True, False]


def test_instances_are_independent():
    first, second = reset_world(Corridor()), reset_world(Corridor())
    first.step(np.array([1.0, 0.0]))
    assert second.observe()[0] == 0
