"""The simulated robot: a kinematic tree made from any URDF, with collision shapes and visuals.

PyBullet simulates a URDF as it is, which fails in known ways: a link without mass weighs 1 kg,
an invalid inertia makes the simulation explode, a robot whose wheels touch the floor creeps, and
wheels slip. The simulated robot (:class:`Body`) is therefore rebuilt:

- It stands on three ideal joints, x, y and heading, instead of its wheels, which collide with
  nothing. Without a drive it is fixed to the world.
- Links that do not move relative to each other are merged, so there is one link per joint.
- Every link has at most one collision shape; additional ones get massless links. If two bodies
  touch at several shapes, the order in which Bullet solves the contacts depends on the past, and
  a replay would not be exact.

:mod:`.bullet_urdf` writes the file that PyBullet loads, :mod:`.visuals` makes what cameras see.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ....compiled import njit
from .. import frames as fr
from ..scenes.scene import Part
from ..scenes.shapes import ensure_cached
from .bullet_urdf import Collider, LinkFrames, Tree, write_urdf
from .checks import check_shapes
from .robot import Robot
from .urdf import Joint
from .visuals import load_visuals, save_visuals


@dataclass(frozen=True)
class Body:
    """A robot as it is simulated and seen.

    Link 0 stands on the floor; link i is moved by joint i - 1 of :attr:`.robot.Robot.joints`.

    Attributes
    ----------
    urdf : Path
        The file that PyBullet loads. Its joints are called base-x, base-y and base-heading (with
        a drive) and joint-1, joint-2, ...
    colliders : tuple of Collider
    source_links : dict
        Name of a link of the robot's URDF -> the simulated link that it is merged into, and its
        frame there, float64 (4, 4).
    parts : tuple of (int, Part)
        Simulated links and something visible on them, in the frame of the link.
    parents : int64 (n,)
        Parent of each link; -1 for link 0.
    frames : float64 (n, 4, 4)
        Frame of each link in its parent when its joint is at zero; of link 0 in the point of the
        floor below the robot: below the middle of the axle, or of the root link without a drive.
    axes : float64 (n, 3)
        Joint axes in the frame of the link.
    prismatic : bool (n,)
        Whether the joint slides along its axis instead of turning about it.
    """

    urdf: Path
    colliders: tuple[Collider, ...]
    source_links: LinkFrames
    parts: tuple[tuple[int, Part], ...]
    parents: np.ndarray
    frames: np.ndarray
    axes: np.ndarray
    prismatic: np.ndarray

    def link_poses(self, base: np.ndarray, joints: np.ndarray) -> np.ndarray:
        """Compute the forward kinematics.

        Parameters
        ----------
        base : float64 (3,)
            x, y (metres) and heading (rad).
        joints : float64 (n - 1,)
            Joint positions, rad or m.

        Returns
        -------
        float64 (n, 4, 4)
            Frames of the links in the world.
        """
        joints = np.asarray(joints, np.float64)
        tree = self.parents, self.frames, self.axes, self.prismatic
        return _link_poses(fr.on_floor(*base), joints, *tree)


def build_body(robot: Robot) -> Body:
    """Build the simulated robot; its files are cached.

    Raises
    ------
    RobotError
        A mesh cannot be read.
    """
    source_links, parents, frames = _merge_links(robot)
    colliders = _collect_colliders(robot, source_links)

    def make(folder: Path) -> None:
        check_shapes(robot)
        write_urdf(folder, robot, Tree(source_links, parents, frames, colliders))
        save_visuals(folder / "parts.npz", robot, source_links)

    folder = ensure_cached("robot", _digest(robot), make)
    return Body(
        urdf=folder / "robot.urdf",
        colliders=colliders,
        source_links=source_links,
        parts=load_visuals(folder / "parts.npz"),
        parents=parents,
        frames=frames,
        axes=np.array([(0.0, 0.0, 1.0), *(joint.axis for joint in robot.joints)]),
        prismatic=np.array([False, *(joint.kind == "prismatic" for joint in robot.joints)]),
    )


@njit()
def _link_poses(base, joints, parents, frames, axes, prismatic):
    poses = np.empty_like(frames)
    motion = np.eye(4)
    poses[0] = base @ frames[0]
    for i in range(1, len(parents)):
        q, axis = joints[i - 1], axes[i]
        motion[:3, :3] = np.eye(3)
        motion[:3, 3] = 0.0
        if prismatic[i]:
            motion[:3, 3] = axis * q
        else:  # Rodrigues' formula
            s, c = np.sin(q), 1 - np.cos(q)
            x, y, z = axis
            motion[0, 0] = 1 - c * (y * y + z * z)
            motion[0, 1] = c * x * y - s * z
            motion[0, 2] = c * x * z + s * y
            motion[1, 0] = c * x * y + s * z
            motion[1, 1] = 1 - c * (x * x + z * z)
            motion[1, 2] = c * y * z - s * x
            motion[2, 0] = c * x * z - s * y
            motion[2, 1] = c * y * z + s * x
            motion[2, 2] = 1 - c * (x * x + y * y)
        poses[i] = poses[parents[i]] @ frames[i] @ motion
    return poses


def _merge_links(robot: Robot) -> tuple[LinkFrames, np.ndarray, np.ndarray]:
    """Merge links that do not move relative to each other.

    Returns the attributes `source_links`, `parents` and `frames` of :class:`Body`.
    """
    urdf, moved_link = robot.urdf, {joint.name: i + 1 for i, joint in enumerate(robot.joints)}
    n = len(moved_link) + 1
    source_links: LinkFrames = {urdf.root: (0, np.eye(4))}
    parents, frames = np.full(n, -1), np.tile(np.eye(4), (n, 1, 1))
    frames[0] = robot.root_frame
    stack = [urdf.root]
    while stack:
        name = stack.pop()
        link, frame = source_links[name]
        for joint in urdf.joints_below(name):
            moved = moved_link.get(joint.name)
            if moved is None:
                source_links[joint.child] = link, frame @ joint.frame @ _fixed_motion(robot, joint)
            else:
                source_links[joint.child] = moved, np.eye(4)
                parents[moved], frames[moved] = link, frame @ joint.frame
            stack.append(joint.child)
    return source_links, parents, frames


def _fixed_motion(robot: Robot, joint: Joint) -> np.ndarray:
    """Return the motion of a joint outside the degrees of freedom: float64 (4, 4)."""
    position = robot.fixed_position(joint)
    if joint.kind == "prismatic":
        return fr.translation(joint.axis, position)
    return fr.rotation(joint.axis, position)


def _collect_colliders(robot: Robot, source_links: LinkFrames) -> tuple[Collider, ...]:
    """Return all collision shapes except those of wheels, which the base joints replace."""
    wheels = {robot.urdf.joints[name].child for name in robot.wheels}
    colliders: list[Collider] = []
    for source, (link, frame) in source_links.items():
        for shape in robot.urdf.links[source].collisions if source not in wheels else ():
            number = sum(collider.link == link for collider in colliders)
            name = f"link-{link}-{number}" if number else f"link-{link}"
            colliders.append(Collider(link, source, name, shape, frame @ shape.frame))
    return tuple(colliders)


def _digest(robot: Robot) -> hashlib._Hash:
    """Hash everything that determines the cached files."""
    content = hashlib.sha256(robot.description.model_dump_json().encode())
    folder = Path(__file__).parents[1]
    sources = [folder / "frames.py", folder / "geometry.py", *sorted(folder.glob("robots/*.py"))]
    sources += [folder / "files.py", folder / "meshfiles.py"]
    sources += [folder / "scenes" / f"{name}.py" for name in ("scene", "scenery", "shapes")]
    for path in [*robot.urdf.files, *sources]:
        content.update(hashlib.sha256(path.read_bytes()).digest())
    for package in ("fast_simplification", "numpy", "scipy", "trimesh"):
        content.update(version(package).encode())
    return content
