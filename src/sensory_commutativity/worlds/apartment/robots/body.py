"""The robot that is simulated, made from any URDF.

PyBullet simulates a robot as it is described, and that goes wrong in known ways: a link without mass weighs 1 kg, an impossible inertia explodes,
an immovable robot whose wheels touch the floor creeps, wheels slip. So the simulated robot is built anew (:class:`Body`):

- it stands on three ideal joints, x, y and heading, in place of its wheels, which collide with nothing; without a drive it is fixed to the world;
- links that do not move against each other become one, with their masses and inertias added up, so that there are as few as joints;
- inertias that no rigid body can have are repaired; collision meshes become convex hulls of few corners;
- no link has more than one collision shape, further ones get weightless links of their own: of two things that touch at several shapes, Bullet
  treats the contacts in an order that depends on what happened before, and a replay would not be exact.

What the camera sees is the same robot: its visual meshes, with fewer triangles.
"""

from __future__ import annotations

import hashlib
import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ....compiled import njit
from .. import frames as fr
from ..scenes.scene import Mesh, Part
from ..scenes.scenery import WEIGHTLESS
from ..scenes.shapes import hull_points, kept, write_points
from .robot import Robot
from .urdf import Joint, Link, RobotError, Shape

BASE_JOINTS = ("base-x", "base-y", "base-heading")
"""The joints that carry a robot with a drive."""

_PLAIN = (0.6, 0.6, 0.62)  # chosen: grey, where a URDF gives no colour
_LIGHTEST = 0.1  # kg; chosen: what a link without any mass weighs, as the joints that carry the base, little beside every robot
_SMALLEST = 0.01  # metres; chosen: a link resists turning at least as a ball of this radius of gyration does


@dataclass(frozen=True)
class Collider:
    """A collision shape of a robot."""

    link: int  # simulated link
    origin: str  # the link of the robot's own URDF that it is of
    name: str  # the link that carries it in what PyBullet loads
    shape: Shape
    frame: np.ndarray  # float64 (4, 4), of the shape in the simulated link


@dataclass(frozen=True)
class Body:
    """A robot as it is simulated and seen. Link 0 stands on the floor; link i is moved by joint i - 1 of :attr:`.robot.Robot.joints`.

    Attributes
    ----------
    urdf : Path
        What PyBullet loads; its joints are called base-x, base-y, base-heading (with a drive) and joint-1, joint-2, ...
    colliders : tuple of Collider
    where : dict
        For every link of the robot's own URDF the simulated link that it is part of and its frame there, float64 (4, 4).
    parts : tuple
        Pairs of a simulated link and something visible on it, in the link's frame.
    parents : int64 (n,)
        The link that each link hangs on; -1 for link 0.
    frames : float64 (n, 4, 4)
        Where each link is, seen from its parent, when its joint is at zero; of link 0 seen from the point of the floor below the robot.
    axes : float64 (n, 3)
        Joint axes in the link's frame.
    slides : bool (n,)
        Whether the joint slides along its axis rather than turn about it.
    """

    urdf: Path
    colliders: tuple[Collider, ...]
    where: dict[str, tuple[int, np.ndarray]]
    parts: tuple[tuple[int, Part], ...]
    parents: np.ndarray
    frames: np.ndarray
    axes: np.ndarray
    slides: np.ndarray

    def link_poses(self, base: np.ndarray, joints: np.ndarray) -> np.ndarray:
        """Frames of the links in the world, float64 (n, 4, 4), of a robot at `base` (x, y, heading) with its joints at `joints`, float64 (n - 1,)."""
        return _link_poses(
            fr.on_floor(*base),
            np.asarray(joints, np.float64),
            self.parents,
            self.frames,
            self.axes,
            self.slides,
        )


def build_body(robot: Robot) -> Body:
    """Make the simulated robot, or take the one kept since it was last made. Raises RobotError for a mesh that cannot be read."""
    where, parents, frames = _merged(robot)
    colliders = _colliders(robot, where)
    kept_in = kept(
        "robot",
        _digest(robot),
        lambda folder: _make(folder, robot, where, parents, frames, colliders),
    )
    axes = np.array([(0.0, 0.0, 1.0), *(joint.axis for joint in robot.joints)])
    slides = np.array([False, *(joint.kind == "prismatic" for joint in robot.joints)])
    return Body(
        kept_in / "robot.urdf",
        colliders,
        where,
        _read_parts(kept_in / "parts.npz"),
        parents,
        frames,
        axes,
        slides,
    )


@njit()
def _link_poses(base, joints, parents, frames, axes, slides):
    poses = np.empty_like(frames)
    motion = np.eye(4)
    poses[0] = base @ frames[0]
    for i in range(1, len(parents)):
        q, axis = joints[i - 1], axes[i]
        motion[:3, :3] = np.eye(3)
        motion[:3, 3] = 0.0
        if slides[i]:
            motion[:3, 3] = axis * q
        else:  # Rodrigues' formula
            s, c = np.sin(q), 1 - np.cos(q)
            x, y, z = axis
            motion[0, 0], motion[0, 1], motion[0, 2] = (
                1 - c * (y * y + z * z),
                c * x * y - s * z,
                c * x * z + s * y,
            )
            motion[1, 0], motion[1, 1], motion[1, 2] = (
                c * x * y + s * z,
                1 - c * (x * x + z * z),
                c * y * z - s * x,
            )
            motion[2, 0], motion[2, 1], motion[2, 2] = (
                c * x * z - s * y,
                c * y * z + s * x,
                1 - c * (x * x + y * y),
            )
        poses[i] = poses[parents[i]] @ frames[i] @ motion
    return poses


# ---- which links become one --------------------------------------------------------------------------------------------------


def _merged(robot: Robot) -> tuple[dict[str, tuple[int, np.ndarray]], np.ndarray, np.ndarray]:
    """`where`, `parents` and `frames` of the body."""
    urdf, moved_by = robot.urdf, {joint.name: i + 1 for i, joint in enumerate(robot.joints)}
    where = {urdf.root: (0, np.eye(4))}
    parents, frames = np.full(len(moved_by) + 1, -1), np.tile(np.eye(4), (len(moved_by) + 1, 1, 1))
    frames[0, 2, 3] = robot.height
    waiting = [urdf.root]
    while waiting:
        link, frame = where[name := waiting.pop()]
        for joint in urdf.joints_below(name):
            moving = moved_by.get(joint.name)
            if moving is None:
                where[joint.child] = link, frame @ joint.frame @ _held(robot, joint)
            else:
                where[joint.child] = moving, np.eye(4)
                parents[moving], frames[moving] = link, frame @ joint.frame
            waiting.append(joint.child)
    return where, parents, frames


def _held(robot: Robot, joint: Joint) -> np.ndarray:
    """What a joint that is no degree of freedom does to its child: float64 (4, 4)."""
    position = robot.description.fixed.get(joint.name, min(max(0.0, joint.lower), joint.upper))
    return (
        fr.shifted(joint.axis, position)
        if joint.kind == "prismatic"
        else fr.turned(joint.axis, position)
    )


def _together(links: list[tuple[Link, np.ndarray]]) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre of mass and frame of principal axes with the inertia about them, of links at their frames: kg, float64 (4, 4), float64 (3,)."""
    mass = sum(link.mass for link, _ in links)
    centre, inertia = np.zeros(3), np.zeros((3, 3))
    if mass > 0:
        centre = sum(link.mass * fr.apply(frame, link.centre) for link, frame in links) / mass
        for link, frame in links:
            if link.mass > 0:
                away, turn = fr.apply(frame, link.centre) - centre, frame[:3, :3]
                inertia += turn @ link.inertia @ turn.T + link.mass * (
                    away @ away * np.eye(3) - np.outer(away, away)
                )
    mass = max(mass, _LIGHTEST)
    values, axes = np.linalg.eigh(inertia)
    values = np.maximum(values, mass * _SMALLEST**2)
    values[2] = min(
        values[2], values[0] + values[1]
    )  # no rigid body has more about one axis than about the other two together
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = axes * [1, 1, np.linalg.det(axes)], centre
    return mass, frame, values


def _colliders(robot: Robot, where: dict[str, tuple[int, np.ndarray]]) -> tuple[Collider, ...]:
    """All collision shapes but those of wheels, which the joints below the base stand in for."""
    wheels, found = {robot.urdf.joints[name].child for name in robot.wheels}, []
    for name, (link, frame) in where.items():
        for shape in robot.urdf.links[name].collisions if name not in wheels else ():
            number = sum(other.link == link for other in found)
            found.append(
                Collider(
                    link,
                    name,
                    f"link-{link}-{number}" if number else f"link-{link}",
                    shape,
                    frame @ shape.frame,
                )
            )
    return tuple(found)


# ---- what is written ---------------------------------------------------------------------------------------------------------


def _digest(robot: Robot) -> hashlib._Hash:
    """Everything that the kept files follow from."""
    here = Path(__file__).parent
    content = hashlib.sha256(robot.description.model_dump_json().encode())
    sources = [
        here / f"{name}.py"
        for name in ("body", "frames", "geometry", "robot", "scene", "shapes", "urdf")
    ]
    for path in [*robot.urdf.files, *sources]:
        content.update(hashlib.sha256(path.read_bytes()).digest())
    for package in ("fast_simplification", "numpy", "scipy", "trimesh"):
        content.update(version(package).encode())
    return content


def _make(
    folder: Path,
    robot: Robot,
    where: dict,
    parents: np.ndarray,
    frames: np.ndarray,
    colliders: tuple[Collider, ...],
) -> None:
    root = ET.Element("robot", name=robot.description.name)
    names = ["world", *(BASE_JOINTS[:2] if robot.wheels else [])]
    for name in names:
        _write_link(root, name, (_LIGHTEST, np.eye(4), np.full(3, _LIGHTEST * 0.3)))
    if robot.wheels:
        for name, parent, axis in zip(BASE_JOINTS, names, [(1, 0, 0), (0, 1, 0)], strict=False):
            _write_joint(root, name, "prismatic", parent, name, np.eye(4), axis)
        _write_joint(root, BASE_JOINTS[2], "continuous", names[2], "link-0", frames[0], (0, 0, 1))
    else:
        _write_joint(root, "floor", "fixed", names[0], "link-0", frames[0], (0, 0, 1))
    for i in range(len(parents)):
        members = [
            (robot.urdf.links[name], frame) for name, (link, frame) in where.items() if link == i
        ]
        _write_link(
            root,
            f"link-{i}",
            _together(members),
            [collider for collider in colliders if collider.name == f"link-{i}"],
            folder,
        )
    for collider in colliders:
        if collider.name != f"link-{collider.link}":
            _write_link(
                root,
                collider.name,
                (WEIGHTLESS, np.eye(4), np.full(3, WEIGHTLESS * _SMALLEST**2)),
                [collider],
                folder,
            )
            _write_joint(
                root,
                collider.name,
                "fixed",
                f"link-{collider.link}",
                collider.name,
                np.eye(4),
                (0, 0, 1),
            )
    for i, joint in enumerate(robot.joints, start=1):
        kind = "prismatic" if joint.kind == "prismatic" else "continuous"
        _write_joint(
            root, f"joint-{i}", kind, f"link-{parents[i]}", f"link-{i}", frames[i], joint.axis
        )
    ET.indent(root)
    (folder / "robot.urdf").write_bytes(ET.tostring(root))
    _write_parts(folder / "parts.npz", robot, where)


def _write_link(
    root: ET.Element,
    name: str,
    inertial: tuple[float, np.ndarray, np.ndarray],
    colliders: list[Collider] | None = None,
    folder: Path | None = None,
) -> None:
    mass, frame, moments = inertial
    link = ET.SubElement(root, "link", name=name)
    element = ET.SubElement(link, "inertial")
    _write_origin(element, frame)
    ET.SubElement(element, "mass", value=repr(float(mass)))
    off_diagonal = {"ixy": "0", "ixz": "0", "iyz": "0"}
    ET.SubElement(
        element,
        "inertia",
        dict(zip(("ixx", "iyy", "izz"), (repr(float(m)) for m in moments), strict=True))
        | off_diagonal,
    )
    for collider in colliders or ():
        collision, shape = ET.SubElement(link, "collision"), collider.shape
        geometry = ET.SubElement(collision, "geometry")
        if shape.kind == "mesh":
            write_points(
                folder / f"{name}.obj",
                hull_points(fr.apply(collider.frame, _load(shape).vertices * shape.size)),
            )  # type: ignore[operator]
            ET.SubElement(geometry, "mesh", filename=f"{name}.obj")
            continue
        _write_origin(collision, collider.frame)
        if shape.kind == "box":
            ET.SubElement(geometry, "box", size=" ".join(repr(2 * half) for half in shape.size))
        elif shape.kind == "cylinder":
            ET.SubElement(
                geometry, "cylinder", radius=repr(shape.size[0]), length=repr(2 * shape.size[1])
            )
        else:
            ET.SubElement(geometry, "sphere", radius=repr(shape.size[0]))


def _write_joint(
    root: ET.Element, name: str, kind: str, parent: str, child: str, frame: np.ndarray, axis
) -> None:
    joint = ET.SubElement(root, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    _write_origin(joint, frame)
    ET.SubElement(joint, "axis", xyz=" ".join(repr(float(a)) for a in axis))
    if (
        kind == "prismatic"
    ):  # a lower limit above the upper one is none for PyBullet; the control keeps joints within their limits
        ET.SubElement(joint, "limit", lower="1", upper="-1", effort="1e9", velocity="1e9")


def _write_origin(element: ET.Element, frame: np.ndarray) -> None:
    xyz, rpy = (
        " ".join(repr(float(value)) for value in values)
        for values in (frame[:3, 3], fr.to_rpy(frame))
    )
    ET.SubElement(element, "origin", xyz=xyz, rpy=rpy)


# ---- what is seen ------------------------------------------------------------------------------------------------------------


def _load(shape: Shape, max_faces: int | None = None) -> Mesh:
    from ..geometry import from_file

    try:
        return from_file(shape.path, max_faces)
    except Exception as error:  # whatever the many readers of mesh files raise
        raise RobotError(
            f"{shape.path}: cannot be read as a mesh ({error}); replace or convert the file"
        ) from None


def _part(shape: Shape, frame: np.ndarray, max_faces: int) -> Part:
    """What is seen of a shape whose own frame is `frame` in the link's."""
    from .. import geometry

    if shape.kind == "mesh":
        mesh = _load(shape, max_faces)
        mesh = replace(mesh, vertices=mesh.vertices * shape.size)
        if np.prod(shape.size) < 0:  # a mirrored mesh is turned inside out
            mesh = replace(
                mesh,
                faces=np.ascontiguousarray(mesh.faces[:, ::-1]),
                uv=np.ascontiguousarray(mesh.uv[:, ::-1]),
            )
    elif shape.kind == "box":
        mesh = geometry.box(shape.size)  # type: ignore[arg-type]
    elif shape.kind == "cylinder":
        mesh = geometry.cylinder(*shape.size)
    else:
        mesh = geometry.sphere(*shape.size)
    return Part(replace(mesh, vertices=fr.apply(frame, mesh.vertices)), shape.colour or _PLAIN)


def _write_parts(path: Path, robot: Robot, where: dict[str, tuple[int, np.ndarray]]) -> None:
    arrays, links, colours = {}, [], []
    for name, (index, frame) in where.items():
        link = robot.urdf.links[name]
        for shape in link.visuals or link.collisions:
            part = _part(shape, frame @ shape.frame, robot.description.faces_per_mesh)
            arrays |= {
                f"{kind}-{len(links)}": getattr(part.mesh, kind)
                for kind in ("vertices", "faces", "uv")
            }
            links.append(index)
            colours.append(part.colour)
    np.savez(
        path, links=np.array(links, np.int64), colours=np.array(colours).reshape(-1, 3), **arrays
    )


def _read_parts(path: Path) -> tuple[tuple[int, Part], ...]:
    with np.load(path) as kept_parts:
        links, colours = kept_parts["links"].tolist(), kept_parts["colours"].tolist()
        meshes = [
            Mesh(*(kept_parts[f"{kind}-{i}"] for kind in ("vertices", "faces", "uv")))
            for i in range(len(links))
        ]
    return tuple(
        (link, Part(mesh, tuple(colour)))
        for link, mesh, colour in zip(links, meshes, colours, strict=True)
    )  # type: ignore[arg-type]
