"""What an apartment consists of, whoever describes it: a floor plan, a mesh file, a test.

Lengths are metres, angles radians, masses kilograms; x and y lie in the floor, z points up, the floor is at z = 0. Rotations are quaternions
(x, y, z, w). Everything here is data: :mod:`.camera` draws the parts, :mod:`.simulation` collides the solids.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ....errors import UserError

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)


class SceneError(UserError):
    """A scene's file is not valid."""


@dataclass(frozen=True)
class Mesh:
    """Triangles with texture coordinates.

    Attributes
    ----------
    vertices : float64 (n, 3), metres
    faces : int32 (m, 3)
        Vertices of each triangle, counter-clockwise seen from outside: the other side is not drawn.
    uv : float32 (m, 3, 2)
        Texture coordinates of each triangle's corners; a texture repeats with period 1.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray


@dataclass(frozen=True)
class Part:
    """A visible piece: a mesh, already in the frame of what it belongs to, in one colour or with a texture tinted by it."""

    mesh: Mesh
    colour: Vector  # red, green, blue in [0, 1]
    texture: str = ""  # a name in textures.TEXTURES; empty: plain


@dataclass(frozen=True)
class Solid:
    """A collision shape, in the frame of what it belongs to.

    `size` is (half x, half y, half z) of a box, (radius, half height) of an upright cylinder, (radius,) of a sphere; empty for the others. A hull is
    the convex hull of `vertices`; a mesh, which only what never moves may have, is `vertices` and `faces` as they are.
    """

    kind: Literal["box", "cylinder", "sphere", "hull", "mesh"]
    size: tuple[float, ...] = ()
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = UPRIGHT
    vertices: np.ndarray | None = None  # float64 (n, 3)
    faces: np.ndarray | None = None  # int32 (m, 3)


@dataclass(frozen=True)
class Fixture:
    """Something that never moves: a wall, a table, a whole scanned room. Parts and solids are in the frame of the world."""

    name: str
    parts: tuple[Part, ...]
    solids: tuple[Solid, ...]
    overhead: bool = False  # ceilings and lintels, left out of views from above


@dataclass(frozen=True)
class Movable:
    """Something that can be pushed. Parts and solids are in its own frame, whose origin is its centre of mass."""

    name: str
    category: str  # box, can, bottle, mug, ball, bowl, ...
    mass: float
    parts: tuple[Part, ...]
    solids: tuple[Solid, ...]
    position: Vector  # where it stands
    rotation: Quaternion = UPRIGHT


@dataclass(frozen=True)
class Area:
    """A rectangle of floor in which a robot may start."""

    name: str
    x: tuple[float, float]
    y: tuple[float, float]


@dataclass(frozen=True)
class Scene:
    """An apartment."""

    name: str
    fixtures: tuple[Fixture, ...]
    movables: tuple[Movable, ...]
    areas: tuple[Area, ...]
    solid_floor: bool = True  # a ground plane at z = 0 carries what falls


IDENTITIES = dict(nothing=0, movable=1, fixture=10_001, robot=1_000_000)
"""What a camera's id image holds: `movable` + i for the i-th movable, `fixture` + i for the i-th fixture, `robot` for every link."""
