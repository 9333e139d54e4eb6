"""The room and its objects: sampling of random, valid start situations.

A start situation (the paper's *s*) is the pose of the agent and the fixed, movable and moving
objects around it, of different shapes and colours (paper, section III-A). Objects are placed one
after the other: with the same seed, a room with eight objects is the room with four and four more.
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

# Object i takes element i of each cycle. Chosen: four objects hold every kind; most can be moved.
KIND_CYCLE = (MOVABLE, FIXED, MOVABLE, MOVING)
SHAPE_CYCLE = (0, 4, 5, 3)  # authors: discs, boxes, pentagons, triangles; vertices, 0 for a disc
PATH_CYCLE = (16, 2, 4)  # authors: circle (as a 16-gon), line, polygon; corners of the path
MAX_VERTICES = max(SHAPE_CYCLE)
MAX_CORNERS = max(PATH_CYCLE)
MAX_ATTEMPTS = 10_000  # chosen: only rooms that are really too full are refused

WALL_COLOURS = np.array([(128, 128, 128), (160, 112, 96), (96, 144, 112), (96, 112, 160)], np.uint8)
"""Bottom, right, top and left wall. Chosen: muted, whereas objects are vivid."""


class PlacementError(UserError):
    """The room is too full: no free place was found for the agent or an object."""


@dataclass(frozen=True)
class FloorZone:
    """A coloured disc on the floor: visible but not solid. The agent starts outside it."""

    x: float  # units
    y: float  # units
    radius: float  # units
    colour: tuple[int, int, int]  # RGB, each in [0, 255]


@dataclass(frozen=True)
class Room:
    """What start situations are sampled from. Lengths in Flatland units, speeds per step."""

    width: float = 600.0  # authors
    height: float = 800.0  # authors
    walls: bool = True  # False: walls are visible but not solid, space is unbounded
    objects: int = 10  # how many; chosen, between the paper's 0 and 12
    wall_thickness: float = 10.0  # chosen; half of it lies inside the room
    # Chosen: walls extend this far outwards, more than a hand moves in one sub-step.
    wall_backing: float = 100.0
    object_radius: tuple[float, float] = (15.0, 30.0)  # chosen: about the size of the agent's base
    object_mass: float = 10.0  # authors
    path_radius: tuple[float, float] = (20.0, 45.0)  # chosen: moving objects stay in their corner
    path_speed: float = 2.0  # chosen: a quarter of the agent's
    clearance: float = 1.0  # chosen: nothing touches at the start
    # Least distance of the agent's centre from a wall at the start. Chosen: just more than the
    # reach of its arms (125).
    start_margin: float = 150.0
    friction: float = 0.8  # simple-playgrounds, FRICTION_ENTITY
    elasticity: float = 0.5  # authors; simple-playgrounds, ELASTICITY_ENTITY
    damping: float = 0.9  # authors; fraction of a free body's velocity that is kept per step
    zones: tuple[FloorZone, ...] = ()


@dataclass(frozen=True)
class Situation:
    """A start situation, at rest, with `n` objects. The arrays must not be changed.

    Attributes
    ----------
    links : float64 (5, 3)
        Pose (x, y, angle) of each link of the agent; units, rad.
    kind : int64 (n,)
        FIXED, MOVABLE or MOVING.
    vertices : int64 (n,)
        Number of vertices of an object's polygon; 0 for a disc.
    radius : float64 (n,)
        Radius of the disc or of the polygon's circumscribed circle, units.
    pose : float64 (n, 3)
        x, y, angle of each object; units, rad.
    colour : uint8 (n, 3)
        RGB.
    corners : int64 (n,)
        Number of corners of a moving object's closed path; 0 for other objects.
    path : float64 (n, 16, 2)
        Those corners, units.
    phase : float64 (n,)
        Distance along its path at which an object starts, units.
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
    def n_objects(self) -> int:
        return len(self.kind)


def sample_situation(room: Room, agent: Polyphemus, rng: np.random.Generator) -> Situation:
    """Sample the agent's pose, then the objects around it.

    Raises
    ------
    PlacementError
        If no free place is found for the agent or an object.
    """
    links, outline = _sample_agent_pose(room, agent, rng)
    n = room.objects
    kind, vertices, corners = _object_types(n)
    radius, pose = np.empty(n), np.empty((n, 3))
    path, phase = np.zeros((n, MAX_CORNERS, 2)), np.zeros(n)
    margin = room.clearance + (room.wall_thickness / 2 if room.walls else 0.0)
    n_placed = _place_objects(
        rng, (room.width, room.height), margin, room.clearance, room.object_radius,
        room.path_radius, outline, (agent.base_radius, agent.arm_width / 2),
        corners, radius, pose, path, phase,
    )  # fmt: skip
    if n_placed < n:
        raise PlacementError(
            f"no free place for object {n_placed + 1} of {n} in a room of "
            f"{room.width:g} x {room.height:g}; use fewer or smaller objects, or a larger room"
        )
    colour = _object_colours(n, rng.random())
    return Situation(links, kind, vertices, radius, pose, colour, corners, path, phase)


@lru_cache
def _object_types(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Kind, number of vertices and number of path corners of each of `n` objects: int64 (n,)."""
    kind = [KIND_CYCLE[i % len(KIND_CYCLE)] for i in range(n)]
    turn = [i // len(KIND_CYCLE) for i in range(n)]
    vertices = [SHAPE_CYCLE[(i + t) % len(SHAPE_CYCLE)] for i, t in enumerate(turn)]
    corners = [
        PATH_CYCLE[t % len(PATH_CYCLE)] if k == MOVING else 0
        for k, t in zip(kind, turn, strict=True)
    ]
    return np.array(kind, np.int64), np.array(vertices, np.int64), np.array(corners, np.int64)


def _sample_agent_pose(
    room: Room, agent: Polyphemus, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Sample a pose with the whole agent inside the walls and its base outside all zones.

    Returns
    -------
    links : float64 (5, 3)
        Poses of the links.
    outline : float64 (7, 3)
        x, y, heading of the base; then x, y, 0 of the shoulder, elbow and hand of each arm.
    """
    margin = (room.wall_thickness / 2 + room.clearance) if room.walls else -math.inf
    reach = margin + np.array([agent.base_radius] + 6 * [agent.arm_width / 2])[:, None]
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
        in_zone = any(
            math.hypot(x - zone.x, y - zone.y) <= zone.radius + agent.base_radius + room.clearance
            for zone in room.zones
        )
        if not in_zone and (points >= reach).all() and (points <= limit - reach).all():
            outline = np.zeros((len(points), 3))
            outline[:, :2], outline[0, 2] = points, heading
            return links, outline
    raise PlacementError(
        f"the agent does not fit into a room of {room.width:g} x {room.height:g}; "
        "make the room larger or the arms shorter"
    )


def _object_colours(n: int, first_hue: float) -> np.ndarray:
    """`n` different vivid colours, uint8 (n, 3), with hues spaced by the golden ratio."""
    golden = (math.sqrt(5) - 1) / 2
    hue = (first_hue + golden * np.arange(n)[:, None]) % 1.0  # (n, 1)
    saturation = np.where(np.arange(n)[:, None] % 2 == 0, 1.0, 0.6)
    pure = np.clip(np.abs((6 * hue + (0.0, 4.0, 2.0)) % 6 - 3) - 1, 0.0, 1.0)  # hue to RGB, (n, 3)
    return np.round(255 * (1 - saturation * (1 - pure))).astype(np.uint8)


@njit()
def _place_objects(
    rng, room_size, margin, clearance, radii, path_radii, outline, agent_size,
    corners, radius, pose, path, phase,
):  # fmt: skip
    """Sample `radius`, `pose`, `path` and `phase` object by object.

    Returns the number of objects that were placed: the first that finds no free place ends the
    loop.
    """
    n = len(radius)
    centres, footprints = np.empty((n, 2)), np.empty(n)
    for i in range(n):
        for _ in range(MAX_ATTEMPTS):
            radius[i] = rng.uniform(radii[0], radii[1])
            orbit = rng.uniform(path_radii[0], path_radii[1]) if corners[i] > 0 else 0.0
            x, y = rng.uniform(0.0, room_size[0]), rng.uniform(0.0, room_size[1])
            footprints[i] = radius[i] + orbit
            if min(x, y, room_size[0] - x, room_size[1] - y) < footprints[i] + margin:
                continue
            centres[i, 0], centres[i, 1] = x, y
            if _is_free(i, centres, footprints, outline, agent_size, clearance):
                break
        else:
            return i
        pose[i, 0], pose[i, 1], pose[i, 2] = x, y, rng.uniform(-math.pi, math.pi)
        if corners[i] > 0:
            for k in range(corners[i]):
                direction = pose[i, 2] + 2 * math.pi * k / corners[i]
                path[i, k, 0] = x + orbit * math.cos(direction)
                path[i, k, 1] = y + orbit * math.sin(direction)
            phase[i] = rng.uniform(0.0, path_length(path[i], corners[i]))
            pose[i, 0], pose[i, 1] = path_point(path[i], corners[i], phase[i])
    return n


@njit()
def _is_free(i, centres, footprints, outline, agent_size, clearance):
    """Whether the disc of object `i` is clear of the agent and of all earlier objects."""
    x, y, reach = centres[i, 0], centres[i, 1], footprints[i]
    base_radius, arm_half_width = agent_size
    if not math.hypot(x - outline[0, 0], y - outline[0, 1]) > reach + base_radius + clearance:
        return False
    for a, b in ((1, 2), (2, 3), (4, 5), (5, 6)):
        gap = _segment_distance(x, y, outline[a, 0], outline[a, 1], outline[b, 0], outline[b, 1])
        if not gap > reach + arm_half_width + clearance:
            return False
    for j in range(i):
        distance = math.hypot(x - centres[j, 0], y - centres[j, 1])
        if not distance > reach + footprints[j] + clearance:
            return False
    return True


@njit()
def _segment_distance(px, py, ax, ay, bx, by):
    """Distance of the point p from the segment from a to b."""
    ex, ey = bx - ax, by - ay
    length2 = ex * ex + ey * ey
    t = 0.0 if length2 == 0 else min(1.0, max(0.0, ((px - ax) * ex + (py - ay) * ey) / length2))
    return math.hypot(px - ax - t * ex, py - ay - t * ey)


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
    """Point (x, y) at `distance` along the closed polygon of :func:`path_length`."""
    remaining = distance % path_length(path, corners)
    for k in range(corners):
        following = (k + 1) % corners
        ex, ey = path[following, 0] - path[k, 0], path[following, 1] - path[k, 1]
        length = math.hypot(ex, ey)
        if remaining <= length:
            return path[k, 0] + ex * remaining / length, path[k, 1] + ey * remaining / length
        remaining -= length
    return path[0, 0], path[0, 1]
