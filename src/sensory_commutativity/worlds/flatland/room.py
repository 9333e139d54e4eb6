"""The room and what stands in it: drawing random, valid start situations.

A start situation (the paper's *s*) is where the agent stands and what is around it: fixed, movable and moving things of different shapes and
colours (paper, section III-A). Things are placed one after the other, so that a room with eight things is the room with four and four more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...compiled import njit
from ...errors import UserError
from .agent import Polyphemus

FIXED, MOVABLE, MOVING = 0, 1, 2
KIND_NAMES = ("fixed", "movable", "moving")
KIND_CYCLE = (
    MOVABLE,
    FIXED,
    MOVABLE,
    MOVING,
)  # chosen: four things hold every kind, and most can be moved
SHAPE_CYCLE = (
    0,
    4,
    5,
    3,
)  # authors: discs, boxes, pentagons, triangles; number of vertices, 0 for a disc
MAX_VERTICES = 5
PATH_CYCLE = (16, 2, 4)  # authors: circle (as a 16-gon), line, polygon; number of corners
MAX_CORNERS = 16
MAX_ATTEMPTS = 10_000

WALL_COLOURS = np.array(
    [(128, 128, 128), (160, 112, 96), (96, 144, 112), (96, 112, 160)], np.uint8
)  # chosen: muted, things are vivid


class PlacementError(UserError):
    """No free place was found: the room is too full for what should stand in it."""


@dataclass(frozen=True)
class Mark:
    """A coloured disc that the eye sees and nothing bumps into: a zone of a task. The agent starts outside it."""

    x: float  # units
    y: float  # units
    radius: float  # units
    colour: tuple[int, int, int]  # RGB, each in [0, 255]


@dataclass(frozen=True)
class Room:
    """What kind of room start situations are drawn for. Lengths in Flatland units, speeds per step."""

    width: float = 600.0  # authors
    height: float = 800.0  # authors
    walls: bool = True  # False: the walls are seen but not solid, space is unbounded
    things: int = 10  # chosen, between the paper's 0 and 12
    wall_thickness: float = 10.0  # chosen; half of it lies inside the room
    wall_backing: float = (
        100.0  # chosen: how far a wall goes on outwards, more than a hand can sweep in a sub-step
    )
    thing_radius: tuple[float, float] = (15.0, 30.0)  # chosen: about the size of the agent's base
    thing_mass: float = 10.0  # authors
    path_radius: tuple[float, float] = (
        20.0,
        45.0,
    )  # chosen: a moving thing stays in its own corner of the room
    path_speed: float = 2.0  # chosen: a quarter of the agent's
    clearance: float = 1.0  # chosen: nothing touches at the start
    start_margin: float = 150.0  # chosen: the agent's middle starts this far from every wall, just out of its arms' reach (125)
    friction: float = 0.8  # simple-playgrounds, FRICTION_ENTITY
    elasticity: float = 0.5  # authors; simple-playgrounds, ELASTICITY_ENTITY
    damping: float = 0.9  # authors; fraction of a free body's velocity kept per step
    marks: tuple[Mark, ...] = ()


@dataclass(frozen=True)
class Situation:
    """A start situation, at rest; `n` things. Arrays are never changed after creation.

    Attributes
    ----------
    links : float64 (5, 3)
        Pose (x, y, angle) of each of the agent's links; units, rad.
    kind : int64 (n,)
        FIXED, MOVABLE or MOVING.
    vertices : int64 (n,)
        Number of corners of a thing; 0 for a disc.
    radius : float64 (n,)
        Radius of the (circumscribed) circle, units.
    pose : float64 (n, 3)
        (x, y, angle) of each thing; units, rad.
    colour : uint8 (n, 3)
        RGB.
    corners : int64 (n,)
        Corners of a moving thing's closed path; 0 where a thing has none.
    path : float64 (n, 16, 2)
        Those corners, units.
    phase : float64 (n,)
        How far along its path a thing starts, units.
    """

    links: np.ndarray
    kind: np.ndarray
    vertices: np.ndarray
    radius: np.ndarray
    pose: np.ndarray
    colour: np.ndarray
    corners: np.ndarray
    path: np.ndarray
    phase: np.ndarray

    @property
    def n_things(self) -> int:
        return len(self.kind)


def draw_situation(room: Room, agent: Polyphemus, rng: np.random.Generator) -> Situation:
    """Draw where the agent stands and then what is around it. Raises PlacementError when a thing finds no place."""
    links, outline = _draw_agent(room, agent, rng)
    n = room.things
    kind, vertices, corners = _assortment(n)
    radius, pose, path, phase = (
        np.empty(n),
        np.empty((n, 3)),
        np.zeros((n, MAX_CORNERS, 2)),
        np.zeros(n),
    )
    margin = room.clearance + (room.wall_thickness / 2 if room.walls else 0.0)
    failed = _draw_things(
        rng, room.width, room.height, margin, room.clearance, room.thing_radius, room.path_radius,
        outline, agent.base_radius, agent.arm_width / 2, corners, radius, pose, path, phase,
    )  # fmt: skip
    if failed >= 0:
        raise PlacementError(
            f"no free place for thing {failed + 1} of {n} in a room of {room.width:g} x {room.height:g}; "
            "ask for fewer or smaller things, or a larger room"
        )
    first_hue = rng.random()
    return Situation(
        links=links, kind=kind, vertices=vertices, radius=radius, pose=pose,
        colour=_colours(n, first_hue), corners=corners, path=path, phase=phase,
    )  # fmt: skip


@lru_cache
def _assortment(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Kinds, numbers of vertices and numbers of path corners of `n` things: int64 (n,) each."""
    kind = [KIND_CYCLE[i % len(KIND_CYCLE)] for i in range(n)]
    turn = [i // len(KIND_CYCLE) for i in range(n)]
    vertices = [SHAPE_CYCLE[(i + t) % len(SHAPE_CYCLE)] for i, t in enumerate(turn)]
    corners = [
        PATH_CYCLE[t % len(PATH_CYCLE)] if k == MOVING else 0
        for k, t in zip(kind, turn, strict=True)
    ]
    return np.array(kind, np.int64), np.array(vertices, np.int64), np.array(corners, np.int64)


def _draw_agent(
    room: Room, agent: Polyphemus, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Draw where the agent stands, all of it inside the walls.

    Returns its links' poses, float64 (5, 3), and its outline: (x, y, heading), then shoulder, elbow and hand of each arm, (x, y), float64 (7, 3).
    """
    margin = (room.wall_thickness / 2 + room.clearance) if room.walls else -math.inf
    limit = np.array([room.width, room.height])
    inset = room.start_margin
    for _ in range(MAX_ATTEMPTS):
        x, y = rng.uniform(inset, room.width - inset), rng.uniform(inset, room.height - inset)
        heading = rng.uniform(-math.pi, math.pi)
        links = agent.link_poses(x, y, heading)
        half = agent.arm_length / 2 * np.stack([np.cos(links[1:, 2]), np.sin(links[1:, 2])], 1)
        starts, ends = links[1:, :2] - half, links[1:, :2] + half
        points = np.concatenate(
            [links[:1, :2], starts[[0]], ends[[0, 1]], starts[[2]], ends[[2, 3]]]
        )
        reach = margin + np.array([agent.base_radius] + 6 * [agent.arm_width / 2])[:, None]
        marked = any(
            math.hypot(x - mark.x, y - mark.y) <= mark.radius + agent.base_radius + room.clearance
            for mark in room.marks
        )
        if not marked and (points >= reach).all() and (points <= limit - reach).all():
            outline = np.zeros((7, 3))
            outline[:, :2], outline[0, 2] = points, heading
            return links, outline
    raise PlacementError(
        f"the agent does not fit into a room of {room.width:g} x {room.height:g}; make the room larger or the arms shorter"
    )


def _colours(n: int, first_hue: float) -> np.ndarray:
    """`n` vivid colours, uint8 (n, 3), their hues spread by the golden ratio so that all differ."""
    golden = (math.sqrt(5) - 1) / 2
    hue = (first_hue + golden * np.arange(n)[:, None]) % 1.0
    saturation = np.where(np.arange(n)[:, None] % 2 == 0, 1.0, 0.6)
    pure = np.clip(
        np.abs((6 * hue + (0.0, 4.0, 2.0)) % 6 - 3) - 1, 0.0, 1.0
    )  # from hue to red, green and blue
    return np.round(255 * (1 - saturation * (1 - pure))).astype(np.uint8)


@njit()
def _segment_distance(px, py, ax, ay, bx, by):
    """Distance of the point p from the segment a b."""
    ex, ey = bx - ax, by - ay
    length2 = ex * ex + ey * ey
    t = 0.0 if length2 == 0 else min(1.0, max(0.0, ((px - ax) * ex + (py - ay) * ey) / length2))
    return math.hypot(px - ax - t * ex, py - ay - t * ey)


@njit()
def _draw_things(
    rng,
    width,
    height,
    margin,
    clearance,
    radii,
    path_radii,
    outline,
    base_radius,
    arm_half_width,
    corners,
    radius,
    pose,
    path,
    phase,
):
    """Fill `radius`, `pose`, `path` and `phase` thing by thing; return the first thing that found no place, or -1."""
    n = len(radius)
    centre, footprint = np.empty((n, 2)), np.empty(n)
    for i in range(n):
        placed = False
        for _ in range(MAX_ATTEMPTS):
            radius[i] = rng.uniform(radii[0], radii[1])
            orbit = rng.uniform(path_radii[0], path_radii[1]) if corners[i] > 0 else 0.0
            reach = radius[i] + orbit
            x = rng.uniform(0.0, width)
            y = rng.uniform(0.0, height)
            if min(x, y, width - x, height - y) < reach + margin:
                continue
            free = (
                math.hypot(x - outline[0, 0], y - outline[0, 1]) > reach + base_radius + clearance
            )
            for a, b in ((1, 2), (2, 3), (4, 5), (5, 6)):
                gap = _segment_distance(
                    x, y, outline[a, 0], outline[a, 1], outline[b, 0], outline[b, 1]
                )
                free = free and gap > reach + arm_half_width + clearance
            for j in range(i):
                free = (
                    free
                    and math.hypot(x - centre[j, 0], y - centre[j, 1])
                    > reach + footprint[j] + clearance
                )
            if not free:
                continue
            placed = True
            centre[i, 0], centre[i, 1], footprint[i] = x, y, reach
            angle = rng.uniform(-math.pi, math.pi)
            pose[i, 0], pose[i, 1], pose[i, 2] = x, y, angle
            if corners[i] > 0:
                for k in range(corners[i]):
                    direction = angle + 2 * math.pi * k / corners[i]
                    path[i, k, 0], path[i, k, 1] = (
                        x + orbit * math.cos(direction),
                        y + orbit * math.sin(direction),
                    )
                phase[i] = rng.uniform(0.0, path_length(path[i], corners[i]))
                pose[i, 0], pose[i, 1] = path_point(path[i], corners[i], phase[i])
            break
        if not placed:
            return i
    return -1


@njit()
def path_length(path, corners):
    """Length of the closed polygon through the first `corners` points of `path`, units."""
    total = 0.0
    for k in range(corners):
        following = (k + 1) % corners
        total += math.hypot(path[following, 0] - path[k, 0], path[following, 1] - path[k, 1])
    return total


@njit()
def path_point(path, corners, distance):
    """The point (x, y) that lies `distance` along that polygon, any number of rounds."""
    left = distance % path_length(path, corners)
    for k in range(corners):
        following = (k + 1) % corners
        ex, ey = path[following, 0] - path[k, 0], path[following, 1] - path[k, 1]
        length = math.hypot(ex, ey)
        if left <= length:
            return path[k, 0] + ex * left / length, path[k, 1] + ey * left / length
        left -= length
    return path[0, 0], path[0, 1]
