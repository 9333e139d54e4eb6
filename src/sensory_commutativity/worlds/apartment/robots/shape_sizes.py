"""Sizes of a robot from its shapes: of its wheels, of its links, of the whole."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from .. import frames as fr
from .urdf import Link, RobotError, Shape, Urdf
from .visuals import build_shape_mesh


def link_points(link: Link) -> np.ndarray:
    """Outermost points of a link, in its frame: float64 (n, 3), metres.

    Of its collision shapes, or of what is visible of it if it has none.

    Raises
    ------
    RobotError
        A mesh cannot be read.
    """
    shapes = link.collisions or link.visuals
    points = [fr.apply(shape.frame, _corners(shape)) for shape in shapes]
    return np.concatenate([np.zeros((0, 3)), *points])


def _corners(shape: Shape) -> np.ndarray:
    """The vertices of a shape, in its frame, of a mesh those of its convex hull: (n, 3)."""
    if shape.path is None or not shape.path.is_file():
        return build_shape_mesh(shape).vertices
    return _mesh_corners(shape.path, shape.size, shape.path.stat().st_mtime_ns)


@lru_cache(256)
def _mesh_corners(path: Path, size: tuple[float, ...], version: int) -> np.ndarray:
    vertices = build_shape_mesh(Shape("mesh", size, np.eye(4), path)).vertices
    try:
        return vertices[ConvexHull(vertices).vertices]
    except (QhullError, ValueError):  # flat
        return vertices


def measure_wheel_radius(urdf: Urdf, joint: str) -> float:
    """Largest distance of a wheel's surface from its joint's axis, metres.

    Raises
    ------
    RobotError
        The wheel has no shape, or none that a wheel can have.
    """
    wheel, axis = urdf.links[urdf.joints[joint].child], urdf.joints[joint].axis
    points = link_points(wheel)
    radius = 0.0
    if len(points):
        radius = float(np.linalg.norm(points - np.outer(points @ axis, axis), axis=1).max())
    if not 1e-3 < radius < 3:
        raise RobotError(
            f"{urdf.path}: the link {wheel.name!r} of the wheel has no shape from which a radius "
            "can be taken; give drive.wheel_radius"
        )
    return radius


def link_frames(urdf: Urdf, positions: Mapping[str, float] | None = None) -> dict[str, np.ndarray]:
    """Frames of the links in the root link, float64 (4, 4) each; joints at 0 if not given."""
    frames, stack = {urdf.root: np.eye(4)}, [urdf.root]
    while stack:
        name = stack.pop()
        for joint in urdf.joints_below(name):
            frame = frames[name] @ joint.frame
            position = (positions or {}).get(joint.name, 0.0)
            if position and joint.kind == "prismatic":
                frame = frame @ fr.translation(joint.axis, position)
            elif position:
                frame = frame @ fr.rotation(joint.axis, position)
            frames[joint.child] = frame
            stack.append(joint.child)
    return frames


def measure_extent(urdf: Urdf, positions: Mapping[str, float] | None = None) -> np.ndarray | None:
    """Lowest and highest x, y and z in the root link: float64 (2, 3); None without shapes."""
    frames = link_frames(urdf, positions)
    points = [fr.apply(frames[name], link_points(link)) for name, link in urdf.links.items()]
    everything = np.concatenate([np.zeros((0, 3)), *points])
    return np.stack([everything.min(0), everything.max(0)]) if len(everything) else None
