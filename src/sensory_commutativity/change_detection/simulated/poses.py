"""The places at which the local SCP is measured: a grid over the rooms, and directions at each."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...worlds.apartment.scenes.scene import Scene


class Pose(NamedTuple):
    """Where a robot stands: the room, x and y in metres, heading in rad."""

    room: str
    x: float
    y: float
    heading: float


def grid_poses(scene: Scene, spacing: float, headings: int) -> list[Pose]:
    """All places of a grid of `spacing` metres, centred in each room, with `headings` evenly spread directions at each."""
    found = []
    for area in scene.areas:
        for x in _centred(*area.x, spacing):
            for y in _centred(*area.y, spacing):
                found += [
                    Pose(area.name, x, y, 2 * math.pi * k / headings) for k in range(headings)
                ]
    return found


def _centred(low: float, high: float, spacing: float) -> list[float]:
    """Points with this spacing in the middle of an interval; one if it is shorter."""
    n = max(1, math.floor((high - low) / spacing))
    return [float(value) for value in (low + high) / 2 + (np.arange(n) - (n - 1) / 2) * spacing]
