"""Data model of an apartment, shared by floor plans, mesh files and tests.

Units are metres, radians and kilograms. The floor is the plane z = 0 with z up. Rotations are
quaternions (x, y, z, w). These classes only hold data: :mod:`..rendering.camera` draws the parts
and :mod:`.scenery` builds collision bodies from the solids.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from ....errors import UserError

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)

SEGMENTATION_IDS = dict(nothing=0, movable=1, fixture=10_001, robot=1_000_000)
"""Values of a segmentation image: `nothing` is background, `movable` + i the i-th movable object,
`fixture` + i the i-th fixture, and `robot` every link of the robot."""


class SceneError(UserError):
    """A scene file is not valid."""


@dataclass(frozen=True)
class Mesh:
    """A textured triangle mesh.

    Attributes
    ----------
    vertices : float64 (n, 3)
        Metres.
    faces : int32 (m, 3)
        Vertex indices of each triangle, counter-clockwise seen from outside. Back faces are not
        drawn, unless the part has two sides.
    uv : float32 (m, 3, 2)
        Texture coordinates of the corners of each triangle. Textures repeat with period 1.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray


@dataclass(frozen=True)
class Part:
    """A visible mesh in the frame of its owner, with one colour or a texture tinted by it."""

    mesh: Mesh
    colour: Vector  # red, green, blue in [0, 1]
    texture: str = ""  # a name in textures.TEXTURES, or empty for a plain colour
    two_sided: bool = False  # whether faces are seen from behind, too


@dataclass(frozen=True)
class Solid:
    """A collision shape in the frame of its owner.

    Attributes
    ----------
    kind : {"box", "cylinder", "sphere", "hull", "mesh"}
        A hull is the convex hull of `vertices`. A mesh is the triangles `faces` over `vertices`;
        only fixtures may have one.
    size : tuple of float
        Metres: half extents (x, y, z) of a box, (radius, half height) of an upright cylinder,
        (radius,) of a sphere; empty for hulls and meshes.
    position, rotation
        Pose in the frame of the owner.
    vertices : float64 (n, 3) or None
    faces : int32 (m, 3) or None
    """

    kind: Literal["box", "cylinder", "sphere", "hull", "mesh"]
    size: tuple[float, ...] = ()
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Quaternion = UPRIGHT
    vertices: np.ndarray | None = None
    faces: np.ndarray | None = None


@dataclass(frozen=True)
class Fixture:
    """A static object: a wall, a table, a scanned room. Its frame is the world frame."""

    name: str
    parts: tuple[Part, ...]
    solids: tuple[Solid, ...]
    overhead: bool = False  # ceilings and lintels, which views from above leave out


@dataclass(frozen=True)
class Movable:
    """An object that can be pushed. The origin of its frame is its centre of mass."""

    name: str
    category: str  # box, can, bottle, mug, ball, bowl, ...
    mass: float
    parts: tuple[Part, ...]
    solids: tuple[Solid, ...]
    position: Vector  # initial pose in the world
    rotation: Quaternion = UPRIGHT


@dataclass(frozen=True)
class Area:
    """An axis-aligned rectangle of floor in which a robot may start: (low, high) in metres."""

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
    solid_floor: bool = True  # whether a ground plane at z = 0 supports the objects

    @cached_property
    def area_shares(self) -> np.ndarray:
        """Size of each area as a share of all: float64 (areas,)."""
        sizes = [(area.x[1] - area.x[0]) * (area.y[1] - area.y[0]) for area in self.areas]
        return np.array(sizes) / np.sum(sizes)


def as_vector(values: Iterable[float]) -> Vector:
    """Return three numbers as a tuple."""
    x, y, z = values
    return x, y, z
