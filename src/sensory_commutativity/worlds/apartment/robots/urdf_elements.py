"""Converts the elements of a URDF file; errors name the file and the element."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import cast, get_args

import numpy as np

from ..files import FileError, find_file, locate
from ..frames import from_rpy
from ..meshfiles import MESH_FORMATS
from ..scenes.scene import Vector
from .urdf import Joint, JointKind, Link, Mimic, RobotError, Shape, ShapeKind
from .xacro_files import REMEDY, find_expression

MAX_LENGTH = 50.0
"""Metres: longest shape of a link, and distance between joints; chosen: larger than every robot."""
OTHER_JOINTS = {
    "planar": "replace it by two prismatic joints and a continuous one; a base that wheels move "
    "needs none: make it fixed, and describe the wheels under drive",
    "spherical": "replace it by three revolute joints",
    "ball": "replace it by three revolute joints",
    "screw": "replace it by a revolute and a prismatic joint, of which one mimics the other",
    "universal": "replace it by two revolute joints",
}
"""Kinds of joints that are not simulated, and what to do."""


class ElementReader:
    """Converts the elements of one file.

    Parameters
    ----------
    path : Path
        The file, for error messages; meshes are found from its folder.
    robot : Element
        The outermost element.

    Attributes
    ----------
    notes : list of str
        What of the file is not simulated as it says.
    """

    def __init__(self, path: Path, robot: ET.Element):
        self._path = path
        self.notes: list[str] = []
        self._materials = {
            material.get("name", ""): self._read_material(material)
            for material in robot.iter("material")
            if len(material)
        }

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
        kind = self._text(element, "type", where).strip().lower()
        floats = kind == "floating"
        if floats:
            kind = "fixed"
            self.notes.append(
                f"{where} is floating: the robot is held where it is placed, and does not fall"
            )
        if kind not in get_args(JointKind):
            remedy = OTHER_JOINTS.get(
                kind, "revolute, continuous, prismatic and fixed are known; choose one"
            )
            raise self._error(f"{where} is of type {kind!r}; {remedy}")
        axis = np.array(self._numbers(element.find("axis"), "xyz", where, 3, "1 0 0"))
        if kind != "fixed" and not np.linalg.norm(axis) > 0:
            raise self._error(f"the axis of {where} has no length; give it a direction")
        lower, upper = -math.inf, math.inf
        if kind in ("revolute", "prismatic"):
            lower, upper = self._limits(element, where)
        frame = self._origin(element, where)
        if np.abs(frame[:3, 3]).max() > MAX_LENGTH:
            raise self._error(
                f"{where} is {np.abs(frame[:3, 3]).max():g} m from its parent, more than "
                f"{MAX_LENGTH:g} m; write metres (are these millimetres?)"
            )
        (velocity,) = self._numbers(element.find("limit"), "velocity", where, 1, "0")
        return Joint(
            name,
            cast(JointKind, kind),
            self._text(element.find("parent"), "link", where),
            self._text(element.find("child"), "link", where),
            frame,
            axis / (np.linalg.norm(axis) or 1),
            lower,
            upper,
            velocity if velocity > 0 else math.nan,
            self._mimic(element, where),
            floats,
        )

    def _mimic(self, element: ET.Element, where: str) -> Mimic | None:
        mimic = element.find("mimic")
        if mimic is None:
            return None
        (multiplier,) = self._numbers(mimic, "multiplier", where, 1, "1")
        (offset,) = self._numbers(mimic, "offset", where, 1, "0")
        return Mimic(self._text(mimic, "joint", f"the <mimic> of {where}"), multiplier, offset)

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
                "add a box, cylinder, capsule, sphere or mesh, or remove it"
            )
        primitive, frame, path = geometry[0], self._origin(element, where), None
        if primitive.tag == "mesh":
            size = self._scale(primitive, where)
            path = self._mesh(self._text(primitive, "filename", where), where)
        else:
            size = self._primitive_size(primitive, where)
        colour, texture = self._material(element.find("material"))
        return Shape(cast(ShapeKind, primitive.tag), size, frame, path, colour, texture)

    def _primitive_size(self, primitive: ET.Element, where: str) -> tuple[float, ...]:
        size: tuple[float, ...]
        if primitive.tag == "box":
            size = tuple(length / 2 for length in self._numbers(primitive, "size", where, 3))
        elif primitive.tag in ("cylinder", "capsule"):
            (radius,) = self._numbers(primitive, "radius", where, 1)
            (length,) = self._numbers(primitive, "length", where, 1)
            size = (radius, length / 2)
        elif primitive.tag == "sphere":
            size = self._numbers(primitive, "radius", where, 1)
        else:
            raise self._error(
                f"{where} has a <{primitive.tag}>; box, cylinder, capsule, sphere and mesh are "
                "known, use one of them"
            )
        if min(size) < 0:
            raise self._error(f"{where} has a {primitive.tag} of negative size; correct its sign")
        if 2 * max(size) > MAX_LENGTH:
            raise self._error(
                f"{where} has a {primitive.tag} of {2 * max(size):g} m, more than "
                f"{MAX_LENGTH:g} m; write metres (are these millimetres?)"
            )
        return size

    def _scale(self, mesh: ET.Element, where: str) -> tuple[float, ...]:
        text = mesh.get("scale") or "1 1 1"
        if len(text.split()) == 1:  # one factor for all axes
            text = " ".join([text] * 3)
        size = self._numbers(ET.Element("mesh", scale=text), "scale", where, 3)
        if 0 in size:
            raise self._error(f"{where} has a mesh with scale {text!r}; no factor may be 0")
        return size

    def _mesh(self, name: str, where: str) -> Path:
        try:
            path = locate(name, self._path.parent)
        except FileError as error:
            raise self._error(f"{where} names the mesh {name!r}, which {error}") from None
        if path.suffix.lower() not in MESH_FORMATS:
            raise self._error(
                f"{where} names the mesh {name!r}; the known formats are {', '.join(MESH_FORMATS)}"
                ", convert it to one of them"
            )
        return path

    def _origin(self, element: ET.Element, where: str) -> np.ndarray:
        """Return the frame of an element's <origin>, float64 (4, 4)."""
        origin = element.find("origin")
        x, y, z = self._numbers(origin, "xyz", where, 3, "0 0 0")
        roll, pitch, yaw = self._numbers(origin, "rpy", where, 3, "0 0 0")
        return from_rpy((x, y, z), (roll, pitch, yaw))

    def _material(self, material: ET.Element | None) -> tuple[Vector | None, Path | None]:
        """Colour and picture of a material, by its name if it has none of its own."""
        if material is None:
            return None, None
        own = self._read_material(material)
        return (
            own
            if own != (None, None)
            else self._materials.get(material.get("name", ""), (None, None))
        )

    def _read_material(self, material: ET.Element) -> tuple[Vector | None, Path | None]:
        colour, texture = material.find("color"), material.find("texture")
        path = None
        if texture is not None and texture.get("filename"):
            path = find_file(str(texture.get("filename")), self._path.parent)
        if colour is None or not colour.get("rgba"):
            return None, path
        count = 3 if len(str(colour.get("rgba")).split()) == 3 else 4
        rgba = self._numbers(colour, "rgba", f"material {material.get('name', '')!r}", count)
        r, g, b = (min(max(value, 0.0), 1.0) for value in rgba[:3])
        return (r, g, b), path

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
            values = tuple(float(part) for part in (text or "").replace(",", " ").split())
        except ValueError:
            values = ()
        if len(values) != count or not all(map(math.isfinite, values)):
            expression = find_expression(text or "")
            if expression is not None:
                raise self._error(
                    f"{where} has {key}={_shorten(text)}: {expression} is an expression of xacro "
                    f"that was not expanded; {REMEDY}"
                )
            plural = "s" * (count > 1)
            raise self._error(
                f"{where} has {key}={_shorten(text)}; give {count} finite number{plural}"
            )
        return values

    def _error(self, message: str) -> RobotError:
        return RobotError(f"{self._path}: {message}")


def _shorten(text: str | None) -> str:
    shown = repr(text)
    return shown if len(shown) <= 80 else shown[:77] + "..."
