"""The contents of a URDF file: links, joints and shapes, and where their meshes are.

:mod:`.urdf_reader` reads the files.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ....errors import UserError
from ..scenes.scene import Vector

MESH_FORMATS = (".stl", ".obj", ".dae", ".ply", ".glb", ".gltf", ".off")
"""Mesh formats of robots that trimesh reads without optional packages."""

JointKind = Literal["revolute", "continuous", "prismatic", "fixed"]
ShapeKind = Literal["box", "cylinder", "sphere", "mesh"]


class RobotError(UserError):
    """A robot's description or its URDF is not valid."""


@dataclass(frozen=True)
class Shape:
    """A visual or collision shape of a link.

    Attributes
    ----------
    kind : {"box", "cylinder", "sphere", "mesh"}
    size : tuple of float
        Metres: (half x, half y, half z) of a box, (radius, half height) of a cylinder along z,
        (radius,) of a sphere; of a mesh its scale factors (x, y, z).
    frame : float64 (4, 4)
        Pose in the link's frame.
    path : Path, optional
        File of a mesh.
    colour : (float, float, float), optional
        Red, green and blue in [0, 1].
    """

    kind: ShapeKind
    size: tuple[float, ...]
    frame: np.ndarray
    path: Path | None = None
    colour: Vector | None = None


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
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    frame: np.ndarray
    axis: np.ndarray
    lower: float
    upper: float


@dataclass(frozen=True)
class Urdf:
    """The contents of a URDF file: a tree of links."""

    path: Path
    root: str
    links: dict[str, Link]
    joints: dict[str, Joint]

    @property
    def files(self) -> list[Path]:
        """The URDF file and all meshes it refers to."""
        meshes = {
            shape.path
            for link in self.links.values()
            for shape in (*link.visuals, *link.collisions)
            if shape.path
        }
        return [self.path, *sorted(meshes)]

    def joints_below(self, link: str) -> list[Joint]:
        """Return the joints whose parent is `link`, in the order of the file."""
        return [joint for joint in self.joints.values() if joint.parent == link]


def find_file(name: str, folder: Path) -> Path | None:
    """Return the path of the file that a URDF in `folder` calls `name`, or None.

    ``package://NAME/REST`` is searched for in a folder NAME that is inside `folder` or one of its
    ancestors, or is one of them, and then in the installed Python package NAME.
    """
    if name.startswith("package://"):
        package, _, rest = name.removeprefix("package://").partition("/")
        ancestors = [folder, *folder.parents]
        candidates = [
            *(ancestor / package / rest for ancestor in ancestors),
            *(ancestor / rest for ancestor in ancestors if ancestor.name == package),
            *(location / rest for location in _find_package(package)),
        ]
    else:
        candidates = [folder / name.removeprefix("file://")]
    try:
        return next((candidate for candidate in candidates if candidate.is_file()), None)
    except OSError:  # the name is too long for a file
        return None


def _find_package(package: str) -> list[Path]:
    """Return the folders of an installed Python package without importing it."""
    try:
        spec = importlib.util.find_spec(package) if package.isidentifier() else None
    except ValueError:  # __main__
        return []
    locations = spec.submodule_search_locations if spec else None
    return [Path(location) for location in locations or []]
