"""SC-experiments at one pose."""

from __future__ import annotations

import numpy as np

from sensory_commutativity.change_detection.simulated.local_scp import play_local_experiments
from sensory_commutativity.change_detection.simulated.poses import Pose

SHOULDER_PAN = 3  # of Fetch's degrees of freedom


def play(world, pose: Pose, length: int = 60, experiments: int = 6, **settings):
    rng = np.random.default_rng(1)
    return play_local_experiments(pose, world, SHOULDER_PAN, length, experiments, rng, **settings)


def test_experiments_differ_where_a_pillar_is_in_the_way_and_nowhere_else(pillar_world):
    blocked = play(pillar_world, Pose("room", 0.0, 0.0, 0.45))
    free = play(pillar_world, Pose("room", -5.0, 0.0, np.pi))
    assert blocked.pictures.shape == (6, 2, 64, 64, 3) and blocked.pictures.dtype == np.uint8
    assert blocked.starts.shape == (6, len(pillar_world.robot.joints))
    assert blocked.different.any() and not free.different.any()
    repeated = play(pillar_world, Pose("room", 0.0, 0.0, 0.45))
    for first, second in zip(blocked, repeated, strict=True):
        assert np.array_equal(first, second)
    assert play(pillar_world, Pose("room", 0.75, 0.0, 0.0), 10, 2) is None  # inside the table


def test_without_steps_at_rest_the_arm_is_still_moving(pillar_world):
    pose = Pose("room", -5.0, 0.0, np.pi)
    pictures = [play(pillar_world, pose, 10, 2, rest_steps=n).pictures for n in (0, 3, 6)]
    assert not np.array_equal(pictures[0], pictures[1])
    assert np.abs(pictures[1].astype(int) - pictures[2]).max() <= 2  # at rest after three steps
