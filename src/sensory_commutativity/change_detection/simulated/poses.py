"""The robot poses at which the local SCP is measured: a grid over the rooms of a scene."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...worlds.apartment.scenes.scene import Scene


class Pose(NamedTuple):
    """Pose of the robot's base.

    Attributes
    ----------
    room : str
        Name of the area in which it lies.
    x, y : float
        Metres.
    heading : float
        Radians.
    """

    room: str
    x: float
    y: float
    heading: float


def grid_poses(scene: Scene, spacing: float, headings: int) -> list[Pose]:
    """Return the poses of a grid that is centred in each room.

    Parameters
    ----------
    scene : Scene
    spacing : float
        Metres between neighbouring grid points.
    headings : int
        Number of evenly spaced headings at each grid point; the first is 0.
    """
    angles = [2 * math.pi * k / headings for k in range(headings)]
    return [
        Pose(area.name, x, y, angle)
        for area in scene.areas
        for x in _centre_points(*area.x, spacing)
        for y in _centre_points(*area.y, spacing)
        for angle in angles
    ]


def _centre_points(low: float, high: float, spacing: float) -> list[float]:
    """Return evenly spaced points centred in an interval; one point if it is too short."""
    n = max(1, math.floor((high - low) / spacing))
    return [float(value) for value in (low + high) / 2 + (np.arange(n) - (n - 1) / 2) * spacing]
