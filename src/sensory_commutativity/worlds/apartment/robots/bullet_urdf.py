"""Writes the URDF of the simulated robot, which PyBullet loads.

Inertias that no rigid body can have are repaired, and collision meshes become convex hulls with
few vertices.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import frames as fr
from ..scenes.scenery import WEIGHTLESS
from ..scenes.shapes import compute_hull_points, write_hull_obj
from .robot import Robot
from .urdf import Link, Shape
from .visuals import load_shape_mesh

BASE_JOINTS = ("base-x", "base-y", "base-heading")
"""The joints that carry a robot with a drive."""

LinkFrames = dict[str, tuple[int, np.ndarray]]
"""Name of a link of the robot's URDF -> simulated link, frame in it: float64 (4, 4)."""

_MIN_MASS = 0.1
"""Kilograms of a link without mass, and of the joints that carry the base; chosen: little compared
with every robot."""
_MIN_GYRATION_RADIUS = 0.01
"""Metres; chosen: a link resists turning at least as much as a ball of this radius of gyration."""

_MAX_GYRATION_RADIUS = 3.0
"""Metres; chosen: no link of a robot is so large. Files with moments in g mm^2 exceed it."""


@dataclass(frozen=True)
class Collider:
    """A collision shape of a robot.

    Attributes
    ----------
    link : int
        Simulated link.
    source : str
        The link of the robot's own URDF that it belongs to.
    name : str
        The link that carries it in the file that PyBullet loads.
    shape : Shape
    frame : float64 (4, 4)
        Pose of the shape in the simulated link.
    """

    link: int
    source: str
    name: str
    shape: Shape
    frame: np.ndarray


class Tree(NamedTuple):
    """The kinematic tree of the simulated robot; see :class:`.body.Body`."""

    source_links: LinkFrames
    parents: np.ndarray
    frames: np.ndarray
    colliders: tuple[Collider, ...]


class Inertial(NamedTuple):
    """Mass, kg; frame of the principal axes, float64 (4, 4); moments, float64 (3,), kg m^2."""

    mass: float
    frame: np.ndarray
    moments: np.ndarray


def write_urdf(folder: Path, robot: Robot, tree: Tree) -> None:
    """Write ``robot.urdf``, and the hulls that it refers to, into `folder`.

    Raises
    ------
    RobotError
        A mesh cannot be read.
    """
    root = ET.Element("robot", name=robot.description.name)
    _add_base(root, robot, tree.frames[0])
    for i in range(len(tree.parents)):
        name = f"link-{i}"
        members = [
            (robot.urdf.links[source], frame)
            for source, (link, frame) in tree.source_links.items()
            if link == i
        ]
        own = [collider for collider in tree.colliders if collider.name == name]
        _add_link(root, name, merge_inertials(members), own, folder)
    massless = Inertial(WEIGHTLESS, np.eye(4), np.full(3, WEIGHTLESS * _MIN_GYRATION_RADIUS**2))
    for collider in tree.colliders:
        name, parent = collider.name, f"link-{collider.link}"
        if name != parent:
            _add_link(root, name, massless, [collider], folder)
            _add_joint(root, name, "fixed", parent, name, np.eye(4), (0, 0, 1))
    for i, joint in enumerate(robot.joints, start=1):
        kind = "prismatic" if joint.kind == "prismatic" else "continuous"
        parent, child = f"link-{tree.parents[i]}", f"link-{i}"
        _add_joint(root, f"joint-{i}", kind, parent, child, tree.frames[i], joint.axis)
    ET.indent(root)
    (folder / "robot.urdf").write_bytes(ET.tostring(root))


def merge_inertials(links: Sequence[tuple[Link, np.ndarray]]) -> Inertial:
    """Return the inertial of several links at their frames as one rigid body.

    Mass and moments are raised to the smallest that simulate well, and brought to what a rigid
    body can have.
    """
    mass = sum(link.mass for link, _ in links)
    centre, inertia = np.zeros(3), np.zeros((3, 3))
    if mass > 0:
        weighted = [link.mass * fr.apply(frame, link.centre) for link, frame in links]
        centre = sum(weighted, start=np.zeros(3)) / mass
        for link, frame in links:
            if link.mass > 0:
                offset, turn = fr.apply(frame, link.centre) - centre, frame[:3, :3]
                steiner = offset @ offset * np.eye(3) - np.outer(offset, offset)
                inertia += turn @ link.inertia @ turn.T + link.mass * steiner
    mass = max(mass, _MIN_MASS)
    moments, axes = np.linalg.eigh(inertia)
    moments = np.clip(moments, mass * _MIN_GYRATION_RADIUS**2, mass * _MAX_GYRATION_RADIUS**2)
    moments[2] = min(moments[2], moments[0] + moments[1])  # triangle inequality of rigid bodies
    frame = np.eye(4)
    frame[:3, :3] = axes * [1, 1, np.linalg.det(axes)]  # right-handed
    frame[:3, 3] = centre
    return Inertial(mass, frame, moments)


def _add_base(root: ET.Element, robot: Robot, frame: np.ndarray) -> None:
    """Add what carries link 0: planar joints for a robot with a drive, else a fixed one."""
    links = ["world", *(BASE_JOINTS[:2] if robot.wheels else [])]
    for name in links:
        _add_link(root, name, Inertial(_MIN_MASS, np.eye(4), np.full(3, _MIN_MASS * 0.3)))
    if not robot.wheels:
        _add_joint(root, "floor", "fixed", links[0], "link-0", frame, (0, 0, 1))
        return
    for name, parent, axis in zip(BASE_JOINTS, links, [(1, 0, 0), (0, 1, 0)], strict=False):
        _add_joint(root, name, "prismatic", parent, name, np.eye(4), axis)
    _add_joint(root, BASE_JOINTS[2], "continuous", links[2], "link-0", frame, (0, 0, 1))


def _add_link(
    root: ET.Element,
    name: str,
    inertial: Inertial,
    colliders: Sequence[Collider] = (),
    folder: Path | None = None,
) -> None:
    link = ET.SubElement(root, "link", name=name)
    element = ET.SubElement(link, "inertial")
    _add_origin(element, inertial.frame)
    ET.SubElement(element, "mass", value=repr(float(inertial.mass)))
    ixx, iyy, izz = (repr(float(moment)) for moment in inertial.moments)
    ET.SubElement(element, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
    for collider in colliders:
        _add_collision(link, collider, folder)


def _add_collision(link: ET.Element, collider: Collider, folder: Path | None) -> None:
    collision, shape = ET.SubElement(link, "collision"), collider.shape
    geometry = ET.SubElement(collision, "geometry")
    if shape.kind == "mesh":
        assert folder is not None
        file = f"{collider.name}.obj"
        vertices = load_shape_mesh(shape).vertices * shape.size
        write_hull_obj(folder / file, compute_hull_points(fr.apply(collider.frame, vertices)))
        ET.SubElement(geometry, "mesh", filename=file)
        return
    _add_origin(collision, collider.frame)
    if shape.kind == "box":
        ET.SubElement(geometry, "box", size=" ".join(repr(2 * half) for half in shape.size))
    elif shape.kind in ("cylinder", "capsule"):
        radius, half_height = shape.size
        ET.SubElement(geometry, shape.kind, radius=repr(radius), length=repr(2 * half_height))
    else:
        ET.SubElement(geometry, "sphere", radius=repr(shape.size[0]))


def _add_joint(
    root: ET.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    frame: np.ndarray,
    axis: Sequence[float] | np.ndarray,
) -> None:
    joint = ET.SubElement(root, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    _add_origin(joint, frame)
    ET.SubElement(joint, "axis", xyz=" ".join(repr(float(a)) for a in axis))
    if kind == "prismatic":
        # To PyBullet a lower limit above the upper one is none; the controller enforces limits.
        ET.SubElement(joint, "limit", lower="1", upper="-1", effort="1e9", velocity="1e9")


def _add_origin(element: ET.Element, frame: np.ndarray) -> None:
    xyz, rpy = (
        " ".join(repr(float(value)) for value in values)
        for values in (frame[:3, 3], fr.to_rpy(frame))
    )
    ET.SubElement(element, "origin", xyz=xyz, rpy=rpy)
