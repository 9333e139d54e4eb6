"""Shapes of the agent, the objects and the walls, shared by the physics and the eye."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from .agent import Polyphemus
from .room import MAX_VERTICES, Room, Situation


@lru_cache
def _regular_polygon(vertices: int) -> np.ndarray:
    """Regular polygon in the unit circle, counter-clockwise: float64 (vertices, 2)."""
    angles = 2 * math.pi * np.arange(vertices) / max(1, vertices)
    return np.stack([np.cos(angles), np.sin(angles)], 1)


def object_outlines(situation: Situation) -> np.ndarray:
    """Polygons of the objects in their own frames, padded with zeros.

    Returns
    -------
    float64 (n, MAX_VERTICES, 2)
        Units; all zeros for a disc.
    """
    outlines = np.zeros((situation.n_objects, MAX_VERTICES, 2))
    for i, vertices in enumerate(situation.vertices):
        outlines[i, :vertices] = situation.radius[i] * _regular_polygon(vertices)
    return outlines


@lru_cache
def arm_outline(agent: Polyphemus) -> np.ndarray:
    """Rectangle of an arm segment in its own frame, units: float64 (4, 2)."""
    x, y = agent.arm_length / 2, agent.arm_width / 2
    return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])


@lru_cache
def wall_lines(room: Room) -> np.ndarray:
    """Middle lines of the bottom, right, top and left wall, units: x1, y1, x2, y2, (4, 4).

    Walls are visible even if they are not solid.
    """
    w, h = room.width, room.height
    return np.array([(w, 0, 0, 0), (w, h, w, 0), (0, h, w, h), (0, 0, 0, h)], np.float64)


@lru_cache
def wall_blocks(room: Room) -> tuple[list[tuple[float, float]], ...]:
    """Corners of the solid part of each wall, units; empty if the walls are not solid.

    Walls extend outwards: no body can jump over them in one sub-step.
    """
    if not room.walls:
        return ()
    inside, outside = room.wall_thickness / 2, room.wall_backing
    blocks = []
    for x1, y1, x2, y2 in wall_lines(room):
        along = np.array([x2 - x1, y2 - y1]) / math.hypot(x2 - x1, y2 - y1)
        outwards = np.array([-along[1], along[0]])
        start, end = np.array([x1, y1]) - outside * along, np.array([x2, y2]) + outside * along
        corners = (
            start - inside * outwards,
            end - inside * outwards,
            end + outside * outwards,
            start + outside * outwards,
        )
        blocks.append([(float(x), float(y)) for x, y in corners])
    return tuple(blocks)
