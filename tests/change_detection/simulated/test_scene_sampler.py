"""Layouts of objects, and the robot among them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from sensory_commutativity.change_detection.outcome import displaced_objects
from sensory_commutativity.change_detection.simulated.robot_placement import (
    MAX_HAND_DISTANCE,
    hand_position,
    place_robot_near_object,
)
from sensory_commutativity.change_detection.simulated.scene_sampler import PUT_DOWN_GAP, REMOVED


@pytest.fixture(scope="module")
def sampler(make_sampler):
    sampler = make_sampler(0, randomize=False)
    sampler.sample_layout()
    return sampler


def test_objects_of_a_layout_lie_in_the_rooms_and_at_rest(sampler):
    poses = sampler.resting_poses
    inside = poses[poses[:, 0] < REMOVED / 2]
    assert len(inside) > 8
    for x, y, z in inside[:, :3]:
        assert z > 0 and any(
            area.x[0] - 0.5 < x < area.x[1] + 0.5 and area.y[0] - 0.5 < y < area.y[1] + 0.5
            for area in sampler.scene.areas
        )
    sampler.simulation.wait(240)
    assert not len(displaced_objects(poses, sampler.simulation.objects.poses()))
    sampler.sample_layout()
    assert len(displaced_objects(poses, sampler.resting_poses)) > 8


def test_an_object_is_put_down_on_the_surface_below_or_removed(sampler):
    simulation, movable = sampler.simulation, sampler.scene.movables[0]
    lowest = min(part.mesh.vertices[:, 2].min() for part in movable.parts)
    area = sampler.scene.areas[0]
    placed = False
    for x in np.linspace(*area.x, 12)[1:-1]:
        sampler.remove_object(0)
        surface = simulation.collisions.surface_below(x, np.mean(area.y), 1.15)
        placed = sampler.place_object(0, x, float(np.mean(area.y)), 1.15)
        pose = simulation.objects.poses()[0]
        if placed:
            assert pose[2] == pytest.approx(surface - lowest + PUT_DOWN_GAP, abs=1e-6)
            break
        assert pose[0] == REMOVED
    assert placed
    assert not sampler.place_object(0, -500.0, -500.0, -0.2)  # below the floor
    assert simulation.objects.poses()[0, 0] == REMOVED


def test_the_hand_starts_near_an_object(sampler):
    objects = sampler.resting_poses
    for seed in range(5):
        rng = np.random.default_rng(seed)
        assert place_robot_near_object(sampler.simulation, objects, rng)
        assert not sampler.simulation.collisions.robot_penetrates()
        distances = np.linalg.norm(objects[:, :2] - hand_position(sampler.simulation)[:2], axis=1)
        assert distances.min() < MAX_HAND_DISTANCE
    nothing_near = np.array([[0.0, 0.0, 50.0, 0, 0, 0, 1]])
    assert not place_robot_near_object(sampler.simulation, nothing_near, np.random.default_rng(0))


def test_a_new_layout_is_sampled_after_the_given_number_of_situations(make_sampler):
    sampler = make_sampler(3)
    layouts = []
    for _ in range(5):
        sampler.sample_situation(2)
        layouts.append(sampler.resting_poses)
    equal = [np.array_equal(a, b) for a, b in pairwise(layouts)]
    assert equal == [True, False, True, False]
