"""Reads and checks URDF files.

The format is https://wiki.ros.org/urdf/XML, with the capsules of PyBullet and Gazebo. Everything
that would stop a simulation later is checked here and reported in one line
(:class:`.urdf.RobotError`).
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import replace
from pathlib import Path

from ..files import FileError
from .urdf import Joint, Link, RobotError, Urdf
from .urdf_elements import ElementReader
from .xacro_files import expand_xacro, is_xacro, substitute_defaults
from .xml_reader import read_xml

MAX_LINKS = 2_000
"""Chosen: a humanoid with two hands has a hundred."""
OTHER_FORMATS = {
    "mujoco": "a model of MuJoCo (MJCF); measure it as an environment (docs/environments.md), or "
    "convert it to URDF",
    "sdf": "a model of Gazebo (SDF); convert it to URDF (gz sdf, or sdformat_urdf)",
    "COLLADA": "a mesh (Collada); name the URDF file that uses it",
    "launch": "a launch file of ROS; name the URDF file that it loads",
    "package": "a package.xml of ROS; name a URDF file of the package",
}
"""Outermost elements of other files, and what to do."""


def read_urdf(path: Path) -> Urdf:
    """Read and check a URDF file; one of xacro is expanded first.

    Raises
    ------
    RobotError
        In one line: the file, what is wrong with it, and how to correct it.
    """
    if not path.exists():
        raise RobotError(
            f"{path}: there is no such URDF file; correct the key urdf of the robot's description"
        )
    try:
        robot = read_xml(path)
        if is_xacro(path, robot):
            robot = expand_xacro(path)
    except FileError as error:
        raise RobotError(f"{path}: {error}") from None
    if robot.tag != "robot":
        known = OTHER_FORMATS.get(robot.tag, "")
        raise RobotError(
            f"{path}: the outermost element is <{robot.tag}>, not <robot>: it is {known}"
            if known
            else f"{path}: the outermost element is <{robot.tag}>, not <robot>; name a URDF file"
        )
    substitute_defaults(robot)
    _check_names(path, robot)
    reader = ElementReader(path, robot)
    links = {link.name: link for link in map(reader.link, robot.findall("link"))}
    joints = {joint.name: joint for joint in map(reader.joint, robot.findall("joint"))}
    root = _find_root(path, links, joints)
    _check_floating(path, joints, root)
    joints = _check_mimics(path, joints, reader.notes)
    name = robot.get("name") or path.stem
    return Urdf(path, root, links, joints, tuple(reader.notes), name)


def _check_names(path: Path, robot: ET.Element) -> None:
    for kind in ("link", "joint"):
        elements = robot.findall(kind)
        if len(elements) > MAX_LINKS:
            raise RobotError(
                f"{path}: has {len(elements):,} {kind}s, more than {MAX_LINKS:,}; leave out what "
                "belongs to no robot"
            )
        counts = Counter(element.get("name") for element in elements)
        duplicate = next((name for name, count in counts.items() if count > 1), None)
        if duplicate is not None:
            raise RobotError(f"{path}: two {kind}s are called {duplicate!r}; rename one")
    if robot.find("link") is None:
        raise RobotError(f"{path}: contains no links, so there is no robot in it; name another")


def _find_root(path: Path, links: dict[str, Link], joints: dict[str, Joint]) -> str:
    """Return the link without a parent. Raises RobotError unless the links form a tree."""
    parents: dict[str, str] = {}
    children: dict[str, list[str]] = {}
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
        children.setdefault(joint.parent, []).append(joint.child)
    roots = [link for link in links if link not in parents]
    if not roots:
        raise RobotError(
            f"{path}: every link is the child of a joint, so the joints form a loop; a robot must "
            "be a tree, remove a joint"
        )
    if len(roots) != 1:
        raise RobotError(
            f"{path}: exactly one link must have no parent, here {len(roots)} have none "
            f"({', '.join(roots[:4])}); connect them by fixed joints"
        )
    reached, stack = set(), [roots[0]]
    while stack:
        link = stack.pop()
        reached.add(link)
        stack.extend(children.get(link, ()))
    if len(reached) < len(links):
        raise RobotError(
            f"{path}: the link {next(name for name in links if name not in reached)!r} is in a "
            "loop of joints; a robot must be a tree, remove one"
        )
    return roots[0]


def _check_floating(path: Path, joints: dict[str, Joint], root: str) -> None:
    """Check that only the root floats: such a robot stands where it is placed."""
    for joint in joints.values():
        if joint.floats and joint.parent != root:
            raise RobotError(
                f"{path}: joint {joint.name!r} is floating, but {joint.parent!r} is not the root; "
                "only the root may float: make the joint fixed, or move the link to a URDF of its "
                "own"
            )


def _check_mimics(path: Path, joints: dict[str, Joint], notes: list[str]) -> dict[str, Joint]:
    """Return the joints without what mimics nothing. Raises RobotError for a loop of mimics."""
    lost = [
        joint
        for joint in joints.values()
        if joint.mimic is not None and joint.mimic.joint not in joints
    ]
    for joint in lost:
        assert joint.mimic is not None
        notes.append(
            f"joint {joint.name!r} mimics {joint.mimic.joint!r}, which does not exist, so it moves "
            "by itself"
        )
    joints = joints | {joint.name: replace(joint, mimic=None) for joint in lost}
    for joint in joints.values():
        seen, current = {joint.name}, joint
        while current.mimic is not None:
            current = joints[current.mimic.joint]
            if current.name in seen:
                raise RobotError(f"{path}: joint {joint.name!r} mimics itself; remove a <mimic>")
            seen.add(current.name)
    return joints
