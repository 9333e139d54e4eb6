"""The grid of poses."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.change_detection.simulated.poses import grid_poses
from sensory_commutativity.worlds.apartment.scenes.scene import Area, Scene


def test_the_grid_is_centred_in_every_room():
    areas = Area("a", (0.0, 1.0), (0.0, 2.1)), Area("b", (5.0, 5.2), (0.0, 1.0))
    poses = grid_poses(Scene("rooms", (), (), areas), 0.5, 2)
    assert len(poses) == len(set(poses)) == 2 * (2 * 4 + 1 * 2)
    assert {pose.heading for pose in poses} == {0.0, np.pi}
    xs = {room: sorted({pose.x for pose in poses if pose.room == room}) for room in "ab"}
    ys = {room: sorted({pose.y for pose in poses if pose.room == room}) for room in "ab"}
    assert xs["a"] == pytest.approx([0.25, 0.75]) and ys["a"] == pytest.approx([0.3, 0.8, 1.3, 1.8])
    assert xs["b"] == pytest.approx([5.1]) and ys["b"] == pytest.approx([0.25, 0.75])
