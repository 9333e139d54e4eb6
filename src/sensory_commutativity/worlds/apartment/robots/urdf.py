"""The contents of a URDF file: links, joints and shapes.

:mod:`.urdf_reader` reads the files.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np

from ....errors import UserError
from ..scenes.scene import Vector

JointKind = Literal["revolute", "continuous", "prismatic", "fixed"]
ShapeKind = Literal["box", "cylinder", "capsule", "sphere", "mesh"]


class RobotError(UserError):
    """A robot's description or its URDF is not valid."""


@dataclass(frozen=True)
class Shape:
    """A visual or collision shape of a link.

    Attributes
    ----------
    kind : {"box", "cylinder", "capsule", "sphere", "mesh"}
    size : tuple of float
        Metres: (half x, half y, half z) of a box, (radius, half height) of a cylinder along z, or
        of a capsule without its caps, (radius,) of a sphere; of a mesh its scale factors (x, y, z).
    frame : float64 (4, 4)
        Pose in the link's frame.
    path : Path, optional
        File of a mesh.
    colour : (float, float, float), optional
        Red, green and blue in [0, 1].
    texture : Path, optional
        Picture that the URDF gives in place of a colour.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    frame: np.ndarray
    path: Path | None = None
    colour: Vector | None = None
    texture: Path | None = None


@dataclass(frozen=True)
class Link:
    """A rigid body of a robot.

    Attributes
    ----------
    name : str
    mass : float
        Kilograms; 0 if the URDF gives none.
    centre : float64 (3,)
        Centre of mass, metres.
    inertia : float64 (3, 3)
        About the centre of mass, along the axes of the link, kg m^2.
    visuals, collisions : tuple of Shape
    """

    name: str
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    visuals: tuple[Shape, ...]
    collisions: tuple[Shape, ...]


@dataclass(frozen=True)
class Mimic:
    """A joint's position is `multiplier` times that of `joint`, plus `offset` (rad or m)."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint between two links.

    Attributes
    ----------
    name : str
    kind : {"revolute", "continuous", "prismatic", "fixed"}
    parent, child : str
        Names of links.
    frame : float64 (4, 4)
        Of the child in the parent when the joint is at zero.
    axis : float64 (3,)
        Unit vector in the child's frame.
    lower, upper : float
        Limits, rad or m; infinite without stops.
    velocity : float
        Maximum velocity, rad/s or m/s; NaN if the URDF gives none.
    mimic : Mimic, optional
        The joint that it follows.
    floats : bool
        Whether the URDF calls it floating: it is simulated as fixed.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    frame: np.ndarray
    axis: np.ndarray
    lower: float
    upper: float
    velocity: float = math.nan
    mimic: Mimic | None = None
    floats: bool = False


@dataclass(frozen=True)
class Urdf:
    """The contents of a URDF file: a tree of links.

    Attributes
    ----------
    path : Path
    root : str
        Name of the link without a parent.
    links, joints : dict
        By name, in the order of the file.
    notes : tuple of str
        What of the file is not simulated as it says, for people.
    name : str
        Of the robot.
    """

    path: Path
    root: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    notes: tuple[str, ...] = ()
    name: str = ""

    @property
    def files(self) -> list[Path]:
        """The URDF file, all meshes it refers to, and the pictures on its links."""
        named = {
            path
            for link in self.links.values()
            for shape in (*link.visuals, *link.collisions)
            for path in (shape.path, shape.texture)
            if path
        }
        return [self.path, *sorted(named)]

    def joints_below(self, link: str) -> list[Joint]:
        """Return the joints whose parent is `link`, in the order of the file."""
        return self._below.get(link, [])

    def joint_above(self, link: str) -> Joint | None:
        """Return the joint whose child is `link`; None for the root."""
        return self._above.get(link)

    @cached_property
    def _below(self) -> dict[str, list[Joint]]:
        below: dict[str, list[Joint]] = {}
        for joint in self.joints.values():
            below.setdefault(joint.parent, []).append(joint)
        return below

    @cached_property
    def _above(self) -> dict[str, Joint]:
        return {joint.child: joint for joint in self.joints.values()}
