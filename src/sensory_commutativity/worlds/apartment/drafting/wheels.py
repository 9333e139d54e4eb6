"""Finds the wheels that move a robot, from the geometry of its URDF."""

from __future__ import annotations

import math
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..robots.shape_sizes import link_frames, link_points, measure_extent
from ..robots.urdf import Joint, Urdf

MAX_TILT = 0.3
"""z component of a wheel's axis at most; chosen: 17 degrees of camber."""
MAX_GAP = 0.3
"""Height of a wheel above the robot's lowest point, in units of its radius; chosen."""
MAX_WIDTH = 4.0
"""Width of a wheel in units of its radius; chosen: rollers are nearly that wide."""


class Wheel(NamedTuple):
    """A wheel on the floor: its joint, centre in the root link (3,), axis (3,) and radius, m."""

    joint: str
    centre: np.ndarray
    axis: np.ndarray
    radius: float


class Drive(NamedTuple):
    """The joints of a differential drive, and where the robot turns (x in the root link, m).

    `heading` is the direction in which it drives, in the root link, rad.
    `idle` are joints of further wheels and casters, which no degree of freedom moves.
    """

    right: str
    left: str
    heading: float
    axle: float | None
    idle: tuple[str, ...]


def find_drive(urdf: Urdf) -> Drive | None:
    """Return the pair of wheels that moves the robot, or None if it has none."""
    wheels = find_wheels(urdf)
    pairs = [pair for pair in combinations(wheels, 2) if _is_pair(*pair)]
    if not pairs:
        return None
    # The widest pair of the largest wheels; of a robot with four, the rear one.
    first, second = max(
        pairs,
        key=lambda pair: (
            round(pair[0].radius, 2),
            round(float(np.linalg.norm((pair[0].centre - pair[1].centre)[:2])), 2),
            -pair[0].centre[0],
        ),
    )
    across = first.centre - second.centre
    if abs(across[1]) >= abs(across[0]):  # drives along x: left is where y is larger
        left, right = (first, second) if across[1] > 0 else (second, first)
    else:  # along y: left is where x is smaller
        left, right = (first, second) if across[0] < 0 else (second, first)
    others = [wheel for wheel in wheels if wheel.joint not in (left.joint, right.joint)]
    driven = [wheel for pair in pairs for wheel in pair if wheel.radius > 0.9 * left.radius]
    axle = None
    if len({wheel.joint for wheel in driven}) > 2 and abs(across[1]) >= abs(across[0]):
        axle = float(np.mean(sorted({round(float(wheel.centre[0]), 4) for wheel in driven})))
    idle = [wheel.joint for wheel in others] + _swivels(urdf, others)
    across = left.centre - right.centre
    heading = math.atan2(-across[0], across[1])
    return Drive(
        right.joint, left.joint, heading if abs(heading) > 0.02 else 0.0, axle, tuple(idle)
    )


def find_wheels(urdf: Urdf) -> list[Wheel]:
    """Return round links on the floor that turn about a level axis."""
    extent = measure_extent(urdf)
    if extent is None:
        return []
    frames, wheels = link_frames(urdf), []
    for joint in urdf.joints.values():
        if joint.kind == "fixed" or joint.kind == "prismatic" or joint.mimic is not None:
            continue
        if joint.kind == "revolute" and joint.upper - joint.lower < 6:
            continue
        frame = frames[joint.child]
        axis, centre = frame[:3, :3] @ joint.axis, frame[:3, 3]
        points = link_points(urdf.links[joint.child])
        if not len(points) or abs(axis[2]) > MAX_TILT:
            continue
        along = points @ joint.axis
        radius = float(np.linalg.norm(points - np.outer(along, joint.axis), axis=1).max())
        gap = centre[2] - radius - extent[0, 2]
        if 5e-3 < radius < 2 and gap <= MAX_GAP * radius and np.ptp(along) <= MAX_WIDTH * radius:
            wheels.append(Wheel(joint.name, centre, axis, radius))
    return wheels


def _is_pair(first: Wheel, second: Wheel) -> bool:
    """Whether two wheels are opposite each other on one axle."""
    across = (first.centre - second.centre)[:2]
    track = float(np.linalg.norm(across))
    if track < 0.02 or abs(first.radius - second.radius) > 0.1 * first.radius:
        return False
    if abs(first.centre[2] - second.centre[2]) > 0.2 * first.radius:
        return False
    return abs(float(across @ first.axis[:2])) > 0.9 * track and (
        abs(float(first.axis @ second.axis)) > 0.9
    )


def _swivels(urdf: Urdf, wheels: list[Wheel]) -> list[str]:
    """Joints that carry casters: they turn about a level, free wheel."""
    names = []
    for wheel in wheels:
        above: Joint | None = urdf.joint_above(urdf.joints[wheel.joint].parent)
        if above is not None and above.kind == "continuous":
            names.append(above.name)
    return names
