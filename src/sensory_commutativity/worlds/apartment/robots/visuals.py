"""Meshes of a robot's shapes, and what cameras see of it, simplified to few triangles."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from .. import frames as fr
from .. import geometry
from ..files import FileError
from ..meshfiles import load_coloured_mesh, load_mesh, mean_picture_colour
from ..scenes.scene import Mesh, Part, Vector
from .robot import Robot
from .urdf import RobotError, Shape
from .urdf_elements import MAX_LENGTH

_DEFAULT_COLOUR = (0.6, 0.6, 0.62)
"""Chosen: grey, if the URDF gives no colour."""

_MESH_ARRAYS = ("vertices", "faces", "uv")


def load_shape_mesh(shape: Shape, max_faces: int | None = None) -> Mesh:
    """Read the mesh file of a shape, unscaled, simplified to about `max_faces` triangles.

    Raises
    ------
    RobotError
        The file cannot be read as a mesh.
    """
    assert shape.path is not None
    try:
        status = shape.path.stat()
        mesh = _load_cached(shape.path, max_faces, status.st_mtime_ns, status.st_size)
    except (FileError, OSError) as error:
        raise RobotError(f"{shape.path}: the mesh {error}") from None
    length = float((np.ptp(mesh.vertices, axis=0) * np.abs(shape.size)).max())
    if length > MAX_LENGTH:
        scale = " ".join(f"{factor / 1000:g}" for factor in shape.size)
        raise RobotError(
            f"{shape.path}: the mesh is {length:g} m long, more than {MAX_LENGTH:g} m; if it is "
            f'in millimetres, write scale="{scale}" in its <mesh> of the URDF'
        )
    return mesh


@lru_cache(64)
def _load_cached(path: Path, max_faces: int | None, *version: int) -> Mesh:
    return load_mesh(path, max_faces)


def build_shape_mesh(shape: Shape, max_faces: int | None = None) -> Mesh:
    """Return a shape's mesh at its size, in the shape's own frame.

    Raises
    ------
    RobotError
        The file of a mesh cannot be read, or is too large.
    """
    if shape.kind == "mesh":
        mesh = load_shape_mesh(shape, max_faces)
        mesh = replace(mesh, vertices=mesh.vertices * shape.size)
        if np.prod(shape.size) < 0:  # mirrored: keep the faces counter-clockwise from outside
            faces = np.ascontiguousarray(mesh.faces[:, ::-1])
            mesh = replace(mesh, faces=faces, uv=np.ascontiguousarray(mesh.uv[:, ::-1]))
        return mesh
    if shape.kind == "box":
        return geometry.box(shape.size)
    if shape.kind == "sphere":
        return geometry.sphere(shape.size[0])
    radius, half_height = shape.size
    make = geometry.cylinder if shape.kind == "cylinder" else geometry.capsule
    return make(radius, half_height)


def save_visuals(path: Path, robot: Robot, source_links: dict[str, tuple[int, np.ndarray]]) -> None:
    """Save everything visible of a robot to an ``npz`` file.

    Parameters
    ----------
    path : Path
    robot : Robot
    source_links : dict
        Name of a link of the URDF -> simulated link and frame in it, float64 (4, 4).

    Raises
    ------
    RobotError
        A mesh cannot be read.
    """
    arrays: dict[str, Any] = {}
    links: list[int] = []
    colours, sides = [], []
    for name, (index, frame) in source_links.items():
        link = robot.urdf.links[name]
        for shape in link.visuals or link.collisions:
            part = _make_part(shape, frame @ shape.frame, robot.description.faces_per_mesh)
            arrays |= {f"{key}-{len(links)}": getattr(part.mesh, key) for key in _MESH_ARRAYS}
            links.append(index)
            colours.append(part.colour)
            sides.append(part.two_sided)
    colour_array = np.array(colours).reshape(-1, 3)
    arrays |= {"links": np.array(links, np.int64), "two_sided": np.array(sides, bool)}
    np.savez(path, colours=colour_array, **arrays)


def load_visuals(path: Path) -> tuple[tuple[int, Part], ...]:
    """Read what :func:`save_visuals` wrote: simulated links, and parts in their frames."""
    parts = []
    with np.load(path) as arrays:
        colours = arrays["colours"].tolist()
        described = zip(arrays["links"].tolist(), colours, arrays["two_sided"], strict=True)
        for i, (link, (r, g, b), two_sided) in enumerate(described):
            mesh = Mesh(*(arrays[f"{key}-{i}"] for key in _MESH_ARRAYS))
            parts.append((link, Part(mesh, (r, g, b), two_sided=bool(two_sided))))
    return tuple(parts)


def _make_part(shape: Shape, frame: np.ndarray, max_faces: int) -> Part:
    """Return the visible part of a shape whose frame in the simulated link is `frame`."""
    mesh = build_shape_mesh(shape, max_faces)
    mesh = replace(mesh, vertices=fr.apply(frame, mesh.vertices))
    inside_out = shape.kind == "mesh" and geometry.volume(mesh) < 0
    colour = shape.colour or _own_colour(shape) or _DEFAULT_COLOUR
    return Part(mesh, colour, two_sided=inside_out)


def _own_colour(shape: Shape) -> Vector | None:
    """Mean colour of a shape's picture, or of its mesh file; None if it has none."""
    if shape.texture is not None:
        return mean_picture_colour(shape.texture)
    if shape.path is None:
        return None
    try:
        mesh, colours, _ = load_coloured_mesh(shape.path)
    except FileError:  # its shape could be read, so only a picture is wrong
        return None
    if colours is None:
        return None
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    r, g, b = (float(c) for c in np.average(colours, axis=0, weights=areas + 1e-12))
    return r, g, b
