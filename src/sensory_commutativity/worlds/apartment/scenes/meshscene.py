"""A user's own scene: a mesh of rooms as scanners and modellers make it (Gibson and Matterport ship such), with things that can be pushed.

The mesh is what is seen and what is touched, as it is. A robot stands on the floor that the mesh has; it is found, or given.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from ....storage.settings import Name, Section
from ..geometry import coloured_from_file
from ..robots.urdf import MESH_FORMATS
from .scene import Area, Fixture, Mesh, Part, Scene, SceneError, Solid, Vector
from .scenefile import ObjectDescription, Pair, no_name_twice, put_down

LEVEL = 0.95
"""Cosine of the slope up to which a face is level; chosen: 18 degrees, since scans are not even."""
SLICE = 0.05
"""Metres: faces within a slice of this height make one surface; chosen: scans of one floor differ by less."""
LEAST_FLOOR = 0.5
"""Square metres: what is smaller is no floor; chosen: a robot needs about a quarter of it."""
BUMP = 0.03
"""Metres: what rises less above the floor is not collided with, or a robot would stand in its own floor; chosen: as uneven as scans are."""
CELL = 0.25
"""Metres: sides of the squares of floor on which a robot may start where no areas are given; chosen: half as wide as robots are."""
SHADES = 4
"""Levels of each colour that are told apart; chosen: up to 64 parts, as colours of scans vary without end."""
GREY = (0.75, 0.74, 0.72)


class StartArea(Section):
    """Where a robot may start."""

    name: Name
    x: Pair
    y: Pair


class MeshScene(Section):
    """A scene from a mesh file."""

    kind: Literal["mesh"]
    name: Name
    about: str = Field("", description="Where it comes from, its licence.")
    mesh: str = Field(
        min_length=1, description="OBJ, PLY, GLB or STL: a path relative to this file."
    )
    scale: float = Field(1.0, gt=0, description="Metres per unit of the mesh.")
    up: Literal["y", "z"] = Field("z", description="Which of the mesh's axes points up.")
    floor: float | None = Field(
        None,
        description="Height of the floor in the mesh, metres; without it the lowest level surface of some size.",
    )
    areas: list[StartArea] = Field(
        default_factory=list,
        description="Where a robot may start, in metres after scaling; without it, wherever there is floor.",
    )
    objects: list[ObjectDescription] = Field(
        default_factory=list,
        description="Things that can be pushed; they stand on the floor, or at a height.",
    )


def build_mesh_scene(settings: MeshScene, path: Path) -> Scene:
    """The scene that the settings describe; `path` is their file. Raises SceneError."""
    where, file = str(path), path.parent / settings.mesh
    if not file.is_file():
        raise SceneError(
            f"{where}: mesh: there is no file {settings.mesh!r}; give a path relative to {path.parent}"
        )
    if (
        file.suffix.lower() not in MESH_FORMATS
    ):  # trimesh would also unpack archives and load what further packages read
        raise SceneError(
            f"{where}: mesh: {settings.mesh!r}; formats that can be read are {', '.join(MESH_FORMATS)}"
        )
    if any(thing.stands_on for thing in settings.objects):
        raise SceneError(
            f"{where}: objects: a mesh has no furniture with names, so nothing can stand on it by name (stands_on); give x, y and height instead"
        )
    try:
        mesh, colours = coloured_from_file(file)
    except Exception as error:  # whatever the many readers of mesh files raise
        raise SceneError(
            f"{where}: mesh: {settings.mesh!r} cannot be read ({error}); convert it to OBJ, PLY, GLB or STL"
        ) from None
    vertices = mesh.vertices * settings.scale
    if settings.up == "y":
        vertices = np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], 1)
    floor = floor_height(vertices, mesh.faces) if settings.floor is None else settings.floor
    if floor is None:
        raise SceneError(
            f"{where}: {settings.mesh!r} has no floor: no level surface of at least {LEAST_FLOOR:g} square metres; "
            f"check scale ({settings.scale:g}) and up ({settings.up}), or give the height of the floor"
        )
    mesh = replace(mesh, vertices=vertices - (0, 0, floor))
    solid = _above(mesh, BUMP)
    fixture = Fixture("mesh", tuple(_parts(mesh, colours)), (solid,) if solid else ())
    areas = tuple(Area(area.name, tuple(area.x), tuple(area.y)) for area in settings.areas)  # type: ignore[arg-type]
    areas = areas or tuple(floor_areas(mesh))
    movables = tuple(put_down(thing, i + 1, where) for i, thing in enumerate(settings.objects))
    no_name_twice([movable.name for movable in movables], "objects", where)
    return Scene(settings.name, (fixture,), movables, areas)


def floor_height(vertices: np.ndarray, faces: np.ndarray) -> float | None:
    """Height of the lowest level surface of some size, metres: float64 (n, 3), int (m, 3); None where there is none."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1) / 2
    for slope in (
        normals[:, 2],
        np.abs(normals[:, 2]),
    ):  # faces that look up, or where there are none any: scans are not always turned the right way
        level = slope > LEVEL * 2 * areas
        height = _lowest_surface(corners[level, :, 2].mean(1), areas[level])
        if height is not None:
            return height
    return None


def floor_areas(mesh: Mesh) -> Iterator[Area]:
    """Squares of CELL on which the floor, at height 0, is found below the middle: where a robot may start, since rooms are seldom rectangles."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    level = (np.abs(normals[:, 2]) > LEVEL * np.linalg.norm(normals, axis=1)) & (
        np.abs(corners[:, :, 2]) <= SLICE
    ).all(1)
    floor = corners[level, :, :2]
    if not len(floor):  # where its height was given: anywhere
        (left, bottom), (right, top) = (
            mesh.vertices[:, :2].min(0).tolist(),
            mesh.vertices[:, :2].max(0).tolist(),
        )
        yield Area("everywhere", (left, right), (bottom, top))
        return
    low, high = floor.min((0, 1)), floor.max((0, 1))
    middles = [np.arange(low[k] + CELL / 2, high[k], CELL) for k in range(2)]
    covered = np.zeros((len(middles[0]), len(middles[1])), bool)
    for a, b, c in floor:
        (left, bottom), (right, top) = np.min((a, b, c), 0), np.max((a, b, c), 0)
        i, j = (
            (middles[k] >= (left, bottom)[k]) & (middles[k] <= (right, top)[k]) for k in range(2)
        )
        if i.any() and j.any():
            x, y = np.meshgrid(middles[0][i], middles[1][j], indexing="ij")
            sides = np.stack(
                [
                    (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
                    for p, q in ((a, b), (b, c), (c, a))
                ]
            )
            covered[np.ix_(i, j)] |= (sides >= 0).all(0) | (sides <= 0).all(0)
    for i, j in zip(*np.nonzero(covered), strict=True):
        (x, y), half = (middles[0][i], middles[1][j]), CELL / 2
        yield Area("floor", (float(x - half), float(x + half)), (float(y - half), float(y + half)))


def _lowest_surface(heights: np.ndarray, sizes: np.ndarray) -> float | None:
    slices = np.floor(heights / SLICE).astype(np.int64)
    for k in np.unique(slices):
        near = np.abs(heights - (k + 0.5) * SLICE) <= SLICE
        if sizes[near].sum() >= LEAST_FLOOR:
            return float(np.average(heights[near], weights=sizes[near]))
    return None


def _above(mesh: Mesh, height: float) -> Solid | None:
    """What a robot can touch: every face that reaches higher than `height`."""
    faces = mesh.faces[(mesh.vertices[mesh.faces, 2] > height).any(1)]
    return (
        Solid("mesh", vertices=mesh.vertices, faces=np.ascontiguousarray(faces))
        if len(faces)
        else None
    )


def _parts(mesh: Mesh, colours: np.ndarray | None) -> list[Part]:
    if colours is None:
        return [Part(mesh, GREY, "plaster")]
    shades = np.minimum((colours * SHADES).astype(np.int64), SHADES - 1) @ (
        SHADES * SHADES,
        SHADES,
        1,
    )
    parts = []
    for shade in np.unique(shades):
        chosen = shades == shade
        colour: Vector = tuple(float(c) for c in colours[chosen].mean(0))  # type: ignore[assignment]
        used, faces = np.unique(mesh.faces[chosen], return_inverse=True)
        parts.append(
            Part(
                Mesh(mesh.vertices[used], faces.reshape(-1, 3).astype(np.int32), mesh.uv[chosen]),
                colour,
                "plaster",
            )
        )
    return parts
