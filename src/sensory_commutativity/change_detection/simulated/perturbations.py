"""Random changes between the two pictures of a pair: of the robot's pose and of objects."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from ...worlds.apartment.physics.simulation import Simulation
from ..outcome import displaced_objects
from .robot_placement import hand_position
from .scene_sampler import SceneSampler

RobotMotion = Literal["turned", "almost", "elsewhere", "arm"]
"""How the robot's pose differs between the two pictures: it turned by 45 degrees or more; it came
back almost, within 45 degrees; it is anywhere else; only its arm moved."""
ROBOT_MOTIONS: dict[RobotMotion, float] = {
    "turned": 0.25,
    "almost": 0.5,
    "elsewhere": 0.15,
    "arm": 0.1,
}
"""Probability of each. Chosen: half are near misses, around the limit between *different* and
*identical*."""
NEAR_HAND_FRACTION = 0.5
"""Fraction of the changes that move the objects nearest the hand. Chosen: SC-experiments mostly
move what the robot touches."""
OBJECT_TRIES = 60
"""Places that are tried for a displaced object before it stays where it is. Chosen."""
FALL_SUBSTEPS, ROLL_SUBSTEPS = 30, 120
"""Physics steps (1/8 s and 1/2 s) in which an object that was put down, or pushed, comes to rest.
Chosen."""


def return_robot(simulation: Simulation, rng: np.random.Generator) -> None:
    """Let the robot come back to its pose, in 30 % of the cases with slightly different joints."""
    if rng.uniform() < 0.3:
        base, joints = simulation.base(), simulation.joints()
        scale = math.exp(rng.uniform(math.log(0.002), math.log(0.04)))  # rad or m
        errors = rng.normal(0, scale, len(joints))
        joints = joints + errors * (rng.uniform(size=len(joints)) < 0.3)
        simulation.place_robot(base, simulation.robot.clip_joints(joints))


def perturb_robot_pose(
    motion: RobotMotion, base: np.ndarray, joints: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return another pose of the robot's base or arm.

    Parameters
    ----------
    motion : str
        "turned", "almost" or "arm".
    base : float64 (3,)
        x, y (metres) and heading (rad); changed in place.
    joints : float64 (joints,)
        Joint positions, rad or m; changed in place. The result may exceed their limits.
    rng : numpy.random.Generator
    """
    if motion == "turned":
        base[2] += rng.choice([-1, 1]) * (
            math.pi / 2 if rng.uniform() < 0.5 else rng.uniform(math.pi / 4, math.pi)
        )
    elif motion == "almost":
        base[2] += rng.choice([-1, 1]) * math.radians(_log_uniform(rng, 0.5, 45.0))
        base[:2] += rng.normal(0, 0.03, 2) * rng.integers(2)
    else:
        n = len(joints)
        bends = rng.choice([-1, 1], n) * np.exp(rng.uniform(math.log(0.01), math.log(1.0), n))
        single = np.arange(n) == rng.integers(n)
        joints += bends * (single if rng.uniform() < 0.7 else rng.uniform(size=n) < 0.4)
    return base, joints


def perturb_objects(sampler: SceneSampler, visible: np.ndarray, before: np.ndarray) -> bool:
    """Displace one or a few of the visible objects.

    Objects that they push are displaced, too, or put back exactly if they moved too little to
    count.

    Parameters
    ----------
    sampler : SceneSampler
    visible : int (k,)
        Indices of the visible objects, in random order.
    before : float64 (objects, 7)
        Present poses of all objects.

    Returns
    -------
    bool
        False if no object could be displaced.
    """
    simulation, rng = sampler.simulation, sampler.rng
    if rng.uniform() < NEAR_HAND_FRACTION:
        distances = np.linalg.norm(before[visible, :3] - hand_position(simulation), axis=1)
        visible = visible[np.argsort(distances, kind="stable")]
    chosen = visible[: int(rng.geometric(0.6))]
    moved = [int(i) for i in chosen if _perturb_object(sampler, int(i), before[i])]
    if not moved:
        return False
    displaced = displaced_objects(before, simulation.objects.poses())
    displaced = np.union1d(np.array(moved), displaced)
    for i in np.setdiff1d(np.arange(len(before)), displaced):
        simulation.objects.place(int(i), before[i])
    return True


def _perturb_object(sampler: SceneSampler, i: int, pose: np.ndarray) -> bool:
    """Push an object (40 %), remove it (20 %), or put it down nearby (30 %) or far away (10 %)."""
    simulation, rng = sampler.simulation, sampler.rng
    action = rng.uniform()
    if action < 0.4:
        direction, speed = rng.uniform(-math.pi, math.pi), rng.uniform(0.2, 1.6)  # m/s
        velocity = [speed * math.cos(direction), speed * math.sin(direction), 0.0]
        simulation.objects.place(i, pose, velocity, rng.normal(0, 4.0, 3).tolist())
        simulation.wait(ROLL_SUBSTEPS)
        return True
    if action < 0.6:
        sampler.remove_object(i)
        return True
    heading = None
    if rng.uniform() < 0.5:
        heading = 2 * math.atan2(pose[5], pose[6]) + rng.normal(0, 0.4)
    base = simulation.base()
    for _ in range(OBJECT_TRIES):
        if action < 0.9:
            origin = pose
            distance, direction = _log_uniform(rng, 0.003, 0.6), rng.uniform(-math.pi, math.pi)
        else:  # in front of the robot
            origin = base
            distance, direction = rng.uniform(0.5, 3.0), base[2] + rng.uniform(-0.6, 0.6)
        x = origin[0] + distance * math.cos(direction)
        y = origin[1] + distance * math.sin(direction)
        lying = rng.uniform() < 0.15
        if sampler.place_object(i, x, y, pose[2] + 0.3, lying, heading):
            simulation.wait(FALL_SUBSTEPS)
            return True
    simulation.objects.place(i, pose)
    return False


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))
