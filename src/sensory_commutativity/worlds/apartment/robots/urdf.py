"""Reading a URDF, the usual description of a robot: its links, its joints, and where its meshes are.

Everything that could stop a simulation later is looked for here, at once, and told in one line (:class:`RobotError`). The format is that of
https://wiki.ros.org/urdf/XML; joints that mimic others are read as joints of their own.
"""

from __future__ import annotations

import importlib.util
import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ....errors import UserError
from ..frames import from_rpy
from ..scenes.scene import Vector

MESH_FORMATS = (".stl", ".obj", ".dae", ".ply", ".glb", ".gltf", ".off")
"""What trimesh can read without further packages, of what robots come with."""


class RobotError(UserError):
    """A robot's description or its URDF is not valid."""


@dataclass(frozen=True)
class Shape:
    """What a link looks like or collides with.

    `size` is (half x, half y, half z) of a box, (radius, half height) of a cylinder along z, (radius,) of a sphere, (x, y, z) factors of a mesh.
    """

    kind: Literal["box", "cylinder", "sphere", "mesh"]
    size: tuple[float, ...]
    frame: np.ndarray  # float64 (4, 4), in the link's frame
    path: Path | None = None  # of a mesh
    colour: Vector | None = None  # red, green, blue in [0, 1]


@dataclass(frozen=True)
class Link:
    """A rigid piece."""

    name: str
    mass: float  # kg; 0 where the URDF gives none
    centre: np.ndarray  # float64 (3,), centre of mass, metres
    inertia: np.ndarray  # float64 (3, 3), about the centre of mass in the link's axes, kg m^2
    visuals: tuple[Shape, ...]
    collisions: tuple[Shape, ...]


@dataclass(frozen=True)
class Joint:
    """What holds two links together."""

    name: str
    kind: Literal["revolute", "continuous", "prismatic", "fixed"]
    parent: str
    child: str
    frame: np.ndarray  # float64 (4, 4), of the child at zero, in the parent's frame
    axis: np.ndarray  # float64 (3,), of length 1, in the child's frame
    lower: float  # rad or m; infinite where nothing stops it
    upper: float


@dataclass(frozen=True)
class Urdf:
    """A robot as its file describes it."""

    path: Path
    root: str
    links: dict[str, Link]
    joints: dict[str, Joint]

    @property
    def files(self) -> list[Path]:
        """The URDF itself and all meshes that it names."""
        meshes = {
            shape.path
            for link in self.links.values()
            for shape in (*link.visuals, *link.collisions)
            if shape.path
        }
        return [self.path, *sorted(meshes)]

    def joints_below(self, link: str) -> list[Joint]:
        """The joints whose parent `link` is, in the file's order."""
        return [joint for joint in self.joints.values() if joint.parent == link]


def find_file(name: str, folder: Path) -> Path | None:
    """Where the file `name` of a URDF in `folder` is; None where there is none.

    ``package://NAME/REST`` is looked for in a folder NAME that lies in `folder` or in a folder above it, or is one of those, and then in the
    installed Python package NAME.
    """
    if name.startswith("package://"):
        package, _, rest = name.removeprefix("package://").partition("/")
        above = [folder, *folder.parents]
        candidates = [place / package / rest for place in above] + [
            place / rest for place in above if place.name == package
        ]
        candidates += [place / rest for place in _installed(package)]
    else:
        candidates = [folder / name.removeprefix("file://")]
    try:
        return next((candidate for candidate in candidates if candidate.is_file()), None)
    except OSError:  # a name that is too long for a file
        return None


def _installed(package: str) -> list[Path]:
    """Folders of an installed Python package, which is not imported."""
    try:
        spec = importlib.util.find_spec(package) if package.isidentifier() else None
    except ValueError:  # __main__
        return []
    return [Path(place) for place in (spec.submodule_search_locations or [] if spec else [])]


def read_urdf(path: Path) -> Urdf:
    """Read and check a URDF. Raises RobotError with one line: what is wrong, where, and the remedy."""
    if not path.is_file():
        raise RobotError(
            f"{path}: there is no such URDF file; correct the key urdf of the robot's description"
        )
    try:
        robot = ET.fromstring(path.read_bytes())
    except ET.ParseError as error:
        raise RobotError(
            f"{path}: not valid XML in line {error.position[0]}; mend the URDF there"
        ) from None
    except (LookupError, ValueError) as error:
        raise RobotError(
            f"{path}: its encoding cannot be read ({error}); save the URDF as UTF-8"
        ) from None
    if robot.tag != "robot":
        raise RobotError(
            f"{path}: the outermost element is <{robot.tag}>, not <robot>; name a URDF file"
        )
    if any("xacro" in element.tag for element in robot.iter()):
        raise RobotError(
            f"{path}: holds xacro elements; turn it into plain URDF first (xacro FILE > robot.urdf)"
        )
    reader = _Reader(path, robot)
    for kind in ("link", "joint"):
        names = [element.get("name") for element in robot.findall(kind)]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise RobotError(f"{path}: two {kind}s are called {twice!r}; rename one")
    links = {link.name: link for link in map(reader.link, robot.findall("link"))}
    joints = {joint.name: joint for joint in map(reader.joint, robot.findall("joint"))}
    return Urdf(path, _root(path, links, joints), links, joints)


def _root(path: Path, links: dict[str, Link], joints: dict[str, Joint]) -> str:
    """The link that hangs on no other; every other must hang on it."""
    parents: dict[str, str] = {}
    for joint in joints.values():
        for link in (joint.parent, joint.child):
            if link not in links:
                raise RobotError(
                    f"{path}: joint {joint.name!r} holds the link {link!r}, which is not there; add the link or correct its name"
                )
        if joint.child in parents:
            raise RobotError(
                f"{path}: the link {joint.child!r} hangs on two joints; a robot must be a tree, remove one"
            )
        parents[joint.child] = joint.parent
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        raise RobotError(
            f"{path}: one link must hang on no other, here {len(roots)} do ({', '.join(roots[:4])}); connect them by fixed joints"
        )
    reached, waiting = {roots[0]}, [roots[0]]
    while waiting:
        link = waiting.pop()
        below = [child for child, parent in parents.items() if parent == link]
        reached.update(below)
        waiting.extend(below)
    if len(reached) < len(links):
        raise RobotError(
            f"{path}: the link {next(iter(set(links) - reached))!r} hangs in a ring of joints; a robot must be a tree, remove one"
        )
    return roots[0]


class _Reader:
    """Elements of one file to values, with errors that name the file and the element."""

    def __init__(self, path: Path, robot: ET.Element):
        self._path = path
        self._colours = {
            material.get("name", ""): self._colour(material)
            for material in robot.findall("material")
        }

    def link(self, element: ET.Element) -> Link:
        name = self._text(element, "name", "a link")
        where = f"link {name!r}"
        mass, centre, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
        inertial = element.find("inertial")
        if inertial is not None and inertial.find("mass") is not None:
            frame = self._origin(inertial, where)
            mass = self._numbers(inertial.find("mass"), "value", where, 1)[0]
            values = dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), 0.0)
            for key in values:
                values[key] = self._numbers(inertial.find("inertia"), key, where, 1, "0")[0]
            own = np.array(
                [
                    [values["ixx"], values["ixy"], values["ixz"]],
                    [0, values["iyy"], values["iyz"]],
                    [0, 0, values["izz"]],
                ]
            )
            own = own + np.triu(own, 1).T
            centre, inertia = frame[:3, 3], frame[:3, :3] @ own @ frame[:3, :3].T
        visuals = tuple(self._shape(shape, where) for shape in element.findall("visual"))
        collisions = tuple(self._shape(shape, where) for shape in element.findall("collision"))
        return Link(name, max(mass, 0.0), centre, inertia, visuals, collisions)

    def joint(self, element: ET.Element) -> Joint:
        name = self._text(element, "name", "a joint")
        where = f"joint {name!r}"
        kind = self._text(element, "type", where)
        if kind not in ("revolute", "continuous", "prismatic", "fixed"):
            raise self._error(
                f"{where} is of type {kind!r}; revolute, continuous, prismatic and fixed are known"
            )
        axis = np.array(self._numbers(element.find("axis"), "xyz", where, 3, "1 0 0"))
        if kind != "fixed" and not np.linalg.norm(axis) > 0:
            raise self._error(f"the axis of {where} has no length; give it a direction")
        lower, upper = -math.inf, math.inf
        if kind in ("revolute", "prismatic"):
            limit = element.find("limit")
            if limit is None:
                raise self._error(f"{where} has no <limit>; add one, or make it continuous")
            lower, upper = (
                self._numbers(limit, key, where, 1, "0")[0] for key in ("lower", "upper")
            )
            if lower > upper:
                raise self._error(
                    f"{where} may move from {lower:g} to {upper:g}; the lower limit must not be above the upper one"
                )
        parent, child = (
            self._text(element.find(end), "link", where) for end in ("parent", "child")
        )
        return Joint(
            name,
            kind,
            parent,
            child,
            self._origin(element, where),
            axis / (np.linalg.norm(axis) or 1),
            lower,
            upper,
        )  # type: ignore[arg-type]

    def _shape(self, element: ET.Element, where: str) -> Shape:
        geometry = element.find("geometry")
        if geometry is None or len(geometry) == 0:
            raise self._error(
                f"{where} has a <{element.tag}> without geometry; add a box, cylinder, sphere or mesh"
            )
        inner, frame, colour, path = geometry[0], self._origin(element, where), None, None
        if inner.tag == "box":
            size = tuple(length / 2 for length in self._numbers(inner, "size", where, 3))
        elif inner.tag == "cylinder":
            size = (
                self._numbers(inner, "radius", where, 1)[0],
                self._numbers(inner, "length", where, 1)[0] / 2,
            )
        elif inner.tag == "sphere":
            size = self._numbers(inner, "radius", where, 1)
        elif inner.tag == "mesh":
            size = self._numbers(inner, "scale", where, 3, "1 1 1")
            path = self._mesh(self._text(inner, "filename", where), where)
        else:
            raise self._error(
                f"{where} has a <{inner.tag}>; box, cylinder, sphere and mesh are known"
            )
        material = element.find("material")
        if material is not None:
            colour = self._colour(material) or self._colours.get(material.get("name", ""))
        return Shape(inner.tag, size, frame, path, colour)  # type: ignore[arg-type]

    def _mesh(self, name: str, where: str) -> Path:
        path = find_file(name, self._path.parent)
        if path is None:
            raise self._error(
                f"{where} names the mesh {name!r}, which is not there; put it beside the URDF or install the package it is in"
            )
        if path.suffix.lower() not in MESH_FORMATS:
            raise self._error(
                f"{where} names the mesh {name!r}; formats that can be read are {', '.join(MESH_FORMATS)}"
            )
        return path

    def _origin(self, element: ET.Element, where: str) -> np.ndarray:
        origin = element.find("origin")
        position, rpy = (self._numbers(origin, key, where, 3, "0 0 0") for key in ("xyz", "rpy"))
        return from_rpy(position, rpy)  # type: ignore[arg-type]

    def _colour(self, material: ET.Element) -> Vector | None:
        colour = material.find("color")
        if colour is None:
            return None
        r, g, b, _ = (
            min(max(value, 0.0), 1.0)
            for value in self._numbers(colour, "rgba", f"material {material.get('name', '')!r}", 4)
        )
        return r, g, b

    def _text(self, element: ET.Element | None, key: str, where: str) -> str:
        value = None if element is None else element.get(key)
        if not value:
            raise self._error(f"{where} lacks {key!r}; add it")
        return value

    def _numbers(
        self,
        element: ET.Element | None,
        key: str,
        where: str,
        count: int,
        default: str | None = None,
    ) -> tuple[float, ...]:
        text = default if element is None or element.get(key) is None else element.get(key)
        try:
            values = tuple(float(part) for part in (text or "").split())
        except ValueError:
            values = ()
        if len(values) != count or not all(map(math.isfinite, values)):
            raise self._error(
                f"{where} has {key}={text!r}; {count} finite number{'s' * (count > 1)} must stand there"
            )
        return values

    def _error(self, message: str) -> RobotError:
        return RobotError(f"{self._path}: {message}")
