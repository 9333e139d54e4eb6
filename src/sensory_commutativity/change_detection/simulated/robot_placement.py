"""Random placement of the robot among the objects of a scene."""

from __future__ import annotations

import math

import numpy as np

from ...worlds.apartment.physics.simulation import PARKED, Simulation
from ...worlds.apartment.physics.starts import arm_links, draw_free_pose
from ...worlds.apartment.robots.robot import Robot

NEAR_OBJECT_FRACTION = 0.75
"""Fraction of situations that start with the hand near an object. Chosen: from uniformly random
poses, few SC-experiments move anything."""
NEAR_OBJECT_TRIES = 300
"""Situations near an object that are tried before the robot is placed anywhere. Chosen: about one
in ten is free of contact."""
MAX_HAND_DISTANCE = 0.4
"""Metres, in the floor plane, between the hand and the object that it starts near. Chosen: as far
as a hand moves in a second."""
MAX_HAND_HEIGHT_DIFFERENCE = 0.15
"""Metres between the heights of the hand and of that object. Chosen, likewise."""
BENT_ARM_FRACTION = 0.5
"""Fraction of the other situations in which the arm is not in its start range. Chosen."""
BENT_ARM_TRIES = 60
"""Arm configurations that are tried before the arm stays in its start range. Chosen."""
JOINT_STD = 0.6
"""Standard deviation of random arm configurations around the start range, as a fraction of 1 rad
(or m), or of a sixth of the joint's range where that is less. Chosen."""


def place_robot(simulation: Simulation, objects: np.ndarray, rng: np.random.Generator) -> None:
    """Place the robot near an object, with probability NEAR_OBJECT_FRACTION, or anywhere.

    Parameters
    ----------
    simulation : Simulation
    objects : float64 (n, 7)
        Poses of the objects that lie in the scene.
    rng : numpy.random.Generator
    """
    if rng.uniform() >= NEAR_OBJECT_FRACTION or not place_robot_near_object(
        simulation, objects, rng
    ):
        place_robot_anywhere(simulation, rng)


def place_robot_anywhere(simulation: Simulation, rng: np.random.Generator) -> None:
    """Place the robot uniformly; its arm is in its start range or, in half of the cases, bent.

    Raises StartError if the scene has no free place.
    """
    draw_free_pose(simulation, rng)
    if rng.uniform() < BENT_ARM_FRACTION:
        base, joints = simulation.base(), simulation.joints()
        for _ in range(BENT_ARM_TRIES):
            if simulation.fits(base, _sample_joints(simulation.robot, joints, rng)):
                return
        simulation.place_robot(base, joints)


def place_robot_near_object(
    simulation: Simulation, objects: np.ndarray, rng: np.random.Generator
) -> bool:
    """Place the robot with its hand near a random object, so that the object is in view.

    Parameters are those of :func:`place_robot`. Returns False if no situation free of contact is
    found.
    """
    robot, areas = simulation.robot, simulation.scene.areas
    simulation.reset(np.array(PARKED), robot.start_ranges.mean(1))
    hand = arm_links(simulation)[-1]
    for _ in range(NEAR_OBJECT_TRIES):
        joints = _sample_joints(robot, robot.draw_joints(rng), rng)
        ahead, left, height = simulation.body.link_poses(np.zeros(3), joints)[hand, :3, 3]
        is_level = np.abs(objects[:, 2] - height) < MAX_HAND_HEIGHT_DIFFERENCE
        candidates = objects[is_level, :2]
        if not len(candidates):
            continue
        heading = rng.uniform(-math.pi, math.pi)
        distance = MAX_HAND_DISTANCE * math.sqrt(rng.uniform())  # uniform over the disc
        direction = rng.uniform(-math.pi, math.pi)
        offset = distance * np.array([math.cos(direction), math.sin(direction)])
        x, y = candidates[int(rng.integers(len(candidates)))] + offset  # of the hand
        x -= ahead * math.cos(heading) - left * math.sin(heading)
        y -= ahead * math.sin(heading) + left * math.cos(heading)
        if not any(a.x[0] < x < a.x[1] and a.y[0] < y < a.y[1] for a in areas):
            continue
        if simulation.fits(np.array([x, y, heading]), joints):
            return True
    return False


def hand_position(simulation: Simulation) -> np.ndarray:
    """Position of the last link of the robot's arm, metres: float64 (3,)."""
    hand = arm_links(simulation)[-1]
    return simulation.body.link_poses(simulation.base(), simulation.joints())[hand, :3, 3]


def _sample_joints(robot: Robot, mean: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Sample joint positions around `mean`, clipped to the limits: float64 (joints,)."""
    spread = np.minimum(1.0, np.diff(robot.limits)[:, 0] / 6)
    return robot.clip_joints(mean + rng.normal(0, JOINT_STD, len(mean)) * spread)
