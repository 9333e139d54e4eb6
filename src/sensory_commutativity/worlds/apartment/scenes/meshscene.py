"""Build a scene from a user's mesh of rooms, such as a scan or a model, with movable objects.

Scanners and modelling tools write such meshes; Gibson and Matterport distribute them. The mesh is
both what the camera sees and what the robot touches. The robot stands on the floor of the mesh,
whose height is estimated unless it is given.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from ....storage.settings import Name, Section
from ..geometry import load_coloured_mesh
from ..robots.urdf import MESH_FORMATS
from .descriptions import ObjectDescription, Pair, check_unique_names, place_object
from .scene import Area, Fixture, Mesh, Part, Scene, SceneError, Solid, as_vector

MIN_LEVEL_COSINE = 0.95
"""Cosine of the steepest slope of a level face; chosen: 18 degrees, since scans are uneven."""
HEIGHT_BIN = 0.05
"""Metres: level faces within a bin of this height form one surface; chosen: scans of one floor
vary less."""
MIN_FLOOR_AREA = 0.5
"""Square metres: smaller surfaces are no floor; chosen: a robot covers about a quarter of it."""
MAX_BUMP_HEIGHT = 0.03
"""Metres: faces that rise less above the floor do not collide. Otherwise a robot would stand inside
its own floor. Chosen: the unevenness of scans."""
START_CELL = 0.25
"""Metres: side of the squares of floor in which a robot may start if the scene names no areas;
chosen: half the width of a robot."""
COLOUR_LEVELS = 4
"""Levels of each colour channel that are kept apart; chosen: limits a scan, whose colours vary
continuously, to 64 parts."""
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
    about: str = Field("", description="Origin and licence.")
    mesh: str = Field(
        min_length=1, description="OBJ, PLY, GLB or STL: a path relative to this file."
    )
    scale: float = Field(1.0, gt=0, description="Metres per unit of the mesh.")
    up: Literal["y", "z"] = Field("z", description="The axis of the mesh that points up.")
    floor: float | None = Field(
        None,
        description="Height of the floor in metres. Default: the lowest large level surface.",
    )
    areas: list[StartArea] = Field(
        default_factory=list,
        description="Where a robot may start, in metres after scaling. Default: all of the floor.",
    )
    objects: list[ObjectDescription] = Field(
        default_factory=list, description="Movable objects on the floor, or at a given height."
    )


def build_mesh_scene(settings: MeshScene, path: Path) -> Scene:
    """Build the scene of a mesh.

    Parameters
    ----------
    settings : MeshScene
    path : Path
        The scene file: mesh paths are relative to it, and error messages name it.

    Raises
    ------
    SceneError
        With one line: the file, the problem and the remedy.
    """
    source = str(path)
    mesh, colours = _read_mesh(settings, path)
    if any(description.stands_on for description in settings.objects):
        raise SceneError(
            f"{source}: objects: a mesh has no furniture with names, so nothing can stand on it by "
            "name (stands_on); give x, y and height instead"
        )
    vertices = mesh.vertices * settings.scale
    if settings.up == "y":
        vertices = np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], 1)
    floor = find_floor_height(vertices, mesh.faces) if settings.floor is None else settings.floor
    if floor is None:
        raise SceneError(
            f"{source}: {settings.mesh!r} has no floor: no level surface of at least "
            f"{MIN_FLOOR_AREA:g} square metres; check scale ({settings.scale:g}) and up "
            f"({settings.up}), or give the height of the floor"
        )
    mesh = replace(mesh, vertices=vertices - (0, 0, floor))
    solid = _build_solid(mesh, MAX_BUMP_HEIGHT)
    fixture = Fixture("mesh", tuple(_split_by_colour(mesh, colours)), (solid,) if solid else ())
    areas = tuple(
        Area(area.name, (area.x[0], area.x[1]), (area.y[0], area.y[1])) for area in settings.areas
    )
    movables = tuple(
        place_object(description, i + 1, source) for i, description in enumerate(settings.objects)
    )
    check_unique_names([movable.name for movable in movables], "objects", source)
    return Scene(settings.name, (fixture,), movables, areas or tuple(find_floor_areas(mesh)))


def _read_mesh(settings: MeshScene, path: Path) -> tuple[Mesh, np.ndarray | None]:
    """The mesh file as it is, and the colours of its faces, float64 (m, 3), if it has any."""
    file = path.parent / settings.mesh
    key = f"{path}: mesh:"
    if not file.is_file():
        raise SceneError(
            f"{key} there is no file {settings.mesh!r}; give a path relative to {path.parent}"
        )
    # Without this check trimesh would also unpack archives and use further packages as readers.
    if file.suffix.lower() not in MESH_FORMATS:
        raise SceneError(
            f"{key} {settings.mesh!r}; formats that can be read are {', '.join(MESH_FORMATS)}"
        )
    try:
        return load_coloured_mesh(file)
    except Exception as error:  # the readers of mesh formats raise almost anything
        raise SceneError(
            f"{key} {settings.mesh!r} cannot be read ({error}); convert it to OBJ, PLY, GLB or STL"
        ) from None


# ---- floor ---------------------------------------------------------------------------------------


def find_floor_height(vertices: np.ndarray, faces: np.ndarray) -> float | None:
    """Estimate the height of the floor: the lowest level surface of at least MIN_FLOOR_AREA.

    Parameters
    ----------
    vertices : float64 (n, 3)
        Metres, z up.
    faces : int (m, 3)

    Returns
    -------
    float or None
        Metres; None if there is no such surface.
    """
    corners, normals = _compute_normals(vertices, faces)
    areas = np.linalg.norm(normals, axis=1) / 2
    # Prefer faces that look up; fall back to any, since the faces of scans may be flipped.
    for vertical in (normals[:, 2], np.abs(normals[:, 2])):
        level = vertical > MIN_LEVEL_COSINE * 2 * areas
        height = _find_lowest_surface(corners[level, :, 2].mean(1), areas[level])
        if height is not None:
            return height
    return None


def find_floor_areas(mesh: Mesh) -> Iterator[Area]:
    """Yield squares of side START_CELL whose centres are above floor at z = 0.

    The squares are small because rooms are seldom rectangles. A mesh without a level face at z = 0,
    whose floor height the user set, yields its bounding rectangle.
    """
    corners, normals = _compute_normals(mesh.vertices, mesh.faces)
    level = np.abs(normals[:, 2]) > MIN_LEVEL_COSINE * np.linalg.norm(normals, axis=1)
    level &= (np.abs(corners[:, :, 2]) <= HEIGHT_BIN).all(1)
    triangles = corners[level, :, :2]  # (k, 3, 2)
    if not len(triangles):
        left, bottom = mesh.vertices[:, :2].min(0).tolist()
        right, top = mesh.vertices[:, :2].max(0).tolist()
        yield Area("everywhere", (left, right), (bottom, top))
        return
    low, high = triangles.min((0, 1)), triangles.max((0, 1))
    x_centres, y_centres = (np.arange(low[k] + START_CELL / 2, high[k], START_CELL) for k in (0, 1))
    covered = np.zeros((len(x_centres), len(y_centres)), bool)
    for triangle in triangles:
        _cover(covered, x_centres, y_centres, triangle)
    half = START_CELL / 2
    for i, j in zip(*np.nonzero(covered), strict=True):
        x, y = x_centres[i], y_centres[j]
        yield Area("floor", (float(x - half), float(x + half)), (float(y - half), float(y + half)))


def _cover(
    covered: np.ndarray, x_centres: np.ndarray, y_centres: np.ndarray, triangle: np.ndarray
) -> None:
    """Set the cells of a grid, bool (nx, ny), whose centres are in a triangle, float64 (3, 2)."""
    a, b, c = triangle
    (left, bottom), (right, top) = triangle.min(0), triangle.max(0)
    i = (x_centres >= left) & (x_centres <= right)
    j = (y_centres >= bottom) & (y_centres <= top)
    if not (i.any() and j.any()):
        return
    x, y = np.meshgrid(x_centres[i], y_centres[j], indexing="ij")
    sides = np.stack(
        [
            (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
            for p, q in ((a, b), (b, c), (c, a))
        ]
    )
    covered[np.ix_(i, j)] |= (sides >= 0).all(0) | (sides <= 0).all(0)


def _compute_normals(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (m, 3, 3) and normals (m, 3) of the faces; a normal is twice as long as the area."""
    corners = vertices[faces]
    return corners, np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _find_lowest_surface(heights: np.ndarray, areas: np.ndarray) -> float | None:
    """Mean height of the lowest bin with enough area of level faces."""
    bins = np.floor(heights / HEIGHT_BIN).astype(np.int64)
    for k in np.unique(bins):
        near = np.abs(heights - (k + 0.5) * HEIGHT_BIN) <= HEIGHT_BIN
        if areas[near].sum() >= MIN_FLOOR_AREA:
            return float(np.average(heights[near], weights=areas[near]))
    return None


# ---- fixture -------------------------------------------------------------------------------------


def _build_solid(mesh: Mesh, height: float) -> Solid | None:
    """The faces that reach higher than `height`, or None if there are none."""
    faces = mesh.faces[(mesh.vertices[mesh.faces, 2] > height).any(1)]
    if not len(faces):
        return None
    return Solid("mesh", vertices=mesh.vertices, faces=np.ascontiguousarray(faces))


def _split_by_colour(mesh: Mesh, colours: np.ndarray | None) -> list[Part]:
    """Split a mesh into parts of similar colour; `colours` is float64 (m, 3) in [0, 1]."""
    if colours is None:
        return [Part(mesh, GREY, "plaster")]
    levels = np.minimum((colours * COLOUR_LEVELS).astype(np.int64), COLOUR_LEVELS - 1)
    bins = levels @ (COLOUR_LEVELS * COLOUR_LEVELS, COLOUR_LEVELS, 1)
    parts = []
    for k in np.unique(bins):
        chosen = bins == k
        colour = as_vector(float(c) for c in colours[chosen].mean(0))
        used, faces = np.unique(mesh.faces[chosen], return_inverse=True)
        faces = faces.reshape(-1, 3).astype(np.int32)
        parts.append(Part(Mesh(mesh.vertices[used], faces, mesh.uv[chosen]), colour, "plaster"))
    return parts
