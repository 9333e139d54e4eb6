"""What cameras see of a robot: the visual shapes of its URDF, simplified to few triangles."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import frames as fr
from .. import geometry
from ..scenes.scene import Mesh, Part
from .robot import Robot
from .urdf import RobotError, Shape

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
        return geometry.load_mesh(shape.path, max_faces)
    except Exception as error:  # the readers of the many mesh formats raise all kinds of errors
        raise RobotError(
            f"{shape.path}: cannot be read as a mesh ({error}); replace or convert the file"
        ) from None


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
    colours = []
    for name, (index, frame) in source_links.items():
        link = robot.urdf.links[name]
        for shape in link.visuals or link.collisions:
            part = _make_part(shape, frame @ shape.frame, robot.description.faces_per_mesh)
            arrays |= {f"{key}-{len(links)}": getattr(part.mesh, key) for key in _MESH_ARRAYS}
            links.append(index)
            colours.append(part.colour)
    colour_array = np.array(colours).reshape(-1, 3)
    np.savez(path, links=np.array(links, np.int64), colours=colour_array, **arrays)


def load_visuals(path: Path) -> tuple[tuple[int, Part], ...]:
    """Read what :func:`save_visuals` wrote: simulated links, and parts in their frames."""
    parts = []
    with np.load(path) as arrays:
        colours = arrays["colours"].tolist()
        for i, (link, (r, g, b)) in enumerate(zip(arrays["links"].tolist(), colours, strict=True)):
            mesh = Mesh(*(arrays[f"{key}-{i}"] for key in _MESH_ARRAYS))
            parts.append((link, Part(mesh, (r, g, b))))
    return tuple(parts)


def _make_part(shape: Shape, frame: np.ndarray, max_faces: int) -> Part:
    """Return the visible part of a shape whose frame in the simulated link is `frame`."""
    if shape.kind == "mesh":
        mesh = load_shape_mesh(shape, max_faces)
        mesh = replace(mesh, vertices=mesh.vertices * shape.size)
        if np.prod(shape.size) < 0:  # mirrored: keep the faces counter-clockwise from outside
            faces = np.ascontiguousarray(mesh.faces[:, ::-1])
            mesh = replace(mesh, faces=faces, uv=np.ascontiguousarray(mesh.uv[:, ::-1]))
    elif shape.kind == "box":
        mesh = geometry.box(shape.size)
    elif shape.kind == "cylinder":
        radius, half_height = shape.size
        mesh = geometry.cylinder(radius, half_height)
    else:
        mesh = geometry.sphere(shape.size[0])
    mesh = replace(mesh, vertices=fr.apply(frame, mesh.vertices))
    return Part(mesh, shape.colour or _DEFAULT_COLOUR)
