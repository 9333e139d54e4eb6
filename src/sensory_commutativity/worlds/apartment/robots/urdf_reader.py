"""Reads and checks URDF files.

The format is https://wiki.ros.org/urdf/XML; ``mimic`` is ignored, so such joints are independent.
Everything that would stop a simulation later is checked here and reported in one line
(:class:`.urdf.RobotError`).
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import cast, get_args

import numpy as np

from ..frames import from_rpy
from ..scenes.scene import Vector
from .urdf import (
    MESH_FORMATS,
    Joint,
    JointKind,
    Link,
    RobotError,
    Shape,
    ShapeKind,
    Urdf,
    find_file,
)


def read_urdf(path: Path) -> Urdf:
    """Read and check a URDF file.

    Raises
    ------
    RobotError
        In one line: the file, what is wrong with it, and how to correct it.
    """
    if not path.is_file():
        raise RobotError(
            f"{path}: there is no such URDF file; correct the key urdf of the robot's description"
        )
    try:
        robot = ET.fromstring(path.read_bytes())
    except ET.ParseError as error:
        line = error.position[0]
        raise RobotError(f"{path}: not valid XML in line {line}; correct the URDF there") from None
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
            f"{path}: contains xacro elements; convert it to plain URDF first "
            "(xacro FILE > robot.urdf)"
        )
    reader = _Reader(path, robot)
    for kind in ("link", "joint"):
        names = [element.get("name") for element in robot.findall(kind)]
        duplicate = next((name for name in names if names.count(name) > 1), None)
        if duplicate is not None:
            raise RobotError(f"{path}: two {kind}s are called {duplicate!r}; rename one")
    links = {link.name: link for link in map(reader.link, robot.findall("link"))}
    joints = {joint.name: joint for joint in map(reader.joint, robot.findall("joint"))}
    return Urdf(path, _find_root(path, links, joints), links, joints)


def _find_root(path: Path, links: dict[str, Link], joints: dict[str, Joint]) -> str:
    """Return the link without a parent. Raises RobotError unless the links form a tree."""
    parents: dict[str, str] = {}
    for joint in joints.values():
        for link in (joint.parent, joint.child):
            if link not in links:
                raise RobotError(
                    f"{path}: joint {joint.name!r} names the link {link!r}, which does not exist; "
                    "add the link or correct its name"
                )
        if joint.child in parents:
            raise RobotError(
                f"{path}: the link {joint.child!r} is the child of two joints; "
                "a robot must be a tree, remove one"
            )
        parents[joint.child] = joint.parent
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        raise RobotError(
            f"{path}: exactly one link must have no parent, here {len(roots)} have none "
            f"({', '.join(roots[:4])}); connect them by fixed joints"
        )
    reached, stack = {roots[0]}, [roots[0]]
    while stack:
        link = stack.pop()
        children = [child for child, parent in parents.items() if parent == link]
        reached.update(children)
        stack.extend(children)
    if len(reached) < len(links):
        raise RobotError(
            f"{path}: the link {next(iter(set(links) - reached))!r} is in a loop of joints; "
            "a robot must be a tree, remove one"
        )
    return roots[0]


class _Reader:
    """Converts the elements of one file; errors name the file and the element."""

    def __init__(self, path: Path, robot: ET.Element):
        self._path = path
        materials = robot.findall("material")
        self._colours = {material.get("name", ""): self._colour(material) for material in materials}

    def link(self, element: ET.Element) -> Link:
        name = self._text(element, "name", "a link")
        where = f"link {name!r}"
        mass, centre, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
        inertial = element.find("inertial")
        if inertial is not None and inertial.find("mass") is not None:
            frame = self._origin(inertial, where)
            (mass,) = self._numbers(inertial.find("mass"), "value", where, 1)
            tensor = self._inertia(inertial.find("inertia"), where)
            centre, inertia = frame[:3, 3], frame[:3, :3] @ tensor @ frame[:3, :3].T
        visuals = tuple(self._shape(shape, where) for shape in element.findall("visual"))
        collisions = tuple(self._shape(shape, where) for shape in element.findall("collision"))
        return Link(name, max(mass, 0.0), centre, inertia, visuals, collisions)

    def joint(self, element: ET.Element) -> Joint:
        name = self._text(element, "name", "a joint")
        where = f"joint {name!r}"
        kind = self._text(element, "type", where)
        if kind not in get_args(JointKind):
            raise self._error(
                f"{where} is of type {kind!r}; revolute, continuous, prismatic and fixed are known"
            )
        axis = np.array(self._numbers(element.find("axis"), "xyz", where, 3, "1 0 0"))
        if kind != "fixed" and not np.linalg.norm(axis) > 0:
            raise self._error(f"the axis of {where} has no length; give it a direction")
        lower, upper = -math.inf, math.inf
        if kind in ("revolute", "prismatic"):
            lower, upper = self._limits(element, where)
        return Joint(
            name,
            cast(JointKind, kind),
            self._text(element.find("parent"), "link", where),
            self._text(element.find("child"), "link", where),
            self._origin(element, where),
            axis / (np.linalg.norm(axis) or 1),
            lower,
            upper,
        )

    def _inertia(self, element: ET.Element | None, where: str) -> np.ndarray:
        """Return a symmetric inertia tensor, float64 (3, 3); missing entries are 0."""
        upper = np.zeros((3, 3))
        for i, j in zip(*np.triu_indices(3), strict=True):
            (upper[i, j],) = self._numbers(element, f"i{'xyz'[i]}{'xyz'[j]}", where, 1, "0")
        return upper + np.triu(upper, 1).T

    def _limits(self, element: ET.Element, where: str) -> tuple[float, float]:
        limit = element.find("limit")
        if limit is None:
            raise self._error(f"{where} has no <limit>; add one, or make it continuous")
        (lower,) = self._numbers(limit, "lower", where, 1, "0")
        (upper,) = self._numbers(limit, "upper", where, 1, "0")
        if lower > upper:
            raise self._error(
                f"{where} has limits from {lower:g} to {upper:g}; "
                "the lower limit must not be above the upper one"
            )
        return lower, upper

    def _shape(self, element: ET.Element, where: str) -> Shape:
        geometry = element.find("geometry")
        if geometry is None or len(geometry) == 0:
            raise self._error(
                f"{where} has a <{element.tag}> without geometry; "
                "add a box, cylinder, sphere or mesh"
            )
        primitive, frame, path = geometry[0], self._origin(element, where), None
        size: tuple[float, ...]
        if primitive.tag == "box":
            size = tuple(length / 2 for length in self._numbers(primitive, "size", where, 3))
        elif primitive.tag == "cylinder":
            (radius,) = self._numbers(primitive, "radius", where, 1)
            (length,) = self._numbers(primitive, "length", where, 1)
            size = (radius, length / 2)
        elif primitive.tag == "sphere":
            size = self._numbers(primitive, "radius", where, 1)
        elif primitive.tag == "mesh":
            size = self._numbers(primitive, "scale", where, 3, "1 1 1")
            path = self._mesh(self._text(primitive, "filename", where), where)
        else:
            raise self._error(
                f"{where} has a <{primitive.tag}>; box, cylinder, sphere and mesh are known"
            )
        colour, material = None, element.find("material")
        if material is not None:
            colour = self._colour(material) or self._colours.get(material.get("name", ""))
        return Shape(cast(ShapeKind, primitive.tag), size, frame, path, colour)

    def _mesh(self, name: str, where: str) -> Path:
        path = find_file(name, self._path.parent)
        if path is None:
            raise self._error(
                f"{where} names the mesh {name!r}, which does not exist; "
                "put it beside the URDF or install the package it is in"
            )
        if path.suffix.lower() not in MESH_FORMATS:
            raise self._error(
                f"{where} names the mesh {name!r}; the known formats are {', '.join(MESH_FORMATS)}"
            )
        return path

    def _origin(self, element: ET.Element, where: str) -> np.ndarray:
        """Return the frame of an element's <origin>, float64 (4, 4)."""
        origin = element.find("origin")
        x, y, z = self._numbers(origin, "xyz", where, 3, "0 0 0")
        roll, pitch, yaw = self._numbers(origin, "rpy", where, 3, "0 0 0")
        return from_rpy((x, y, z), (roll, pitch, yaw))

    def _colour(self, material: ET.Element) -> Vector | None:
        colour = material.find("color")
        if colour is None:
            return None
        rgba = self._numbers(colour, "rgba", f"material {material.get('name', '')!r}", 4)
        r, g, b, _ = (min(max(value, 0.0), 1.0) for value in rgba)
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
        """Return the `count` finite numbers of an attribute; `default` if it is missing."""
        text = default if element is None or element.get(key) is None else element.get(key)
        try:
            values = tuple(float(part) for part in (text or "").split())
        except ValueError:
            values = ()
        if len(values) != count or not all(map(math.isfinite, values)):
            plural = "s" * (count > 1)
            raise self._error(f"{where} has {key}={text!r}; give {count} finite number{plural}")
        return values

    def _error(self, message: str) -> RobotError:
        return RobotError(f"{self._path}: {message}")
