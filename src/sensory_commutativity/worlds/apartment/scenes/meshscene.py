"""Build a scene from a user's mesh of rooms, such as a scan or a model, with movable objects.

Scanners and modelling tools write such meshes; Gibson and Matterport distribute them. The mesh is
both what the camera sees and what the robot touches, from both sides of its faces, since their
orientation is often mixed. The robot stands on the floor of the mesh, whose height is estimated
unless it is given.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from ....storage.settings import Name, Section
from ..files import FileError
from ..meshfiles import MESH_FORMATS, load_coloured_mesh
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
COLOUR_LEVELS = 12
"""Levels of each colour channel that are kept apart; chosen: limits a scan, whose colours vary
continuously, to 1,728 parts, and no colour is changed by more than a twelfth."""
MAX_SLAB = 0.5
"""Metres: thickness of a floor at most; chosen: thicker than floors of buildings."""
EXTENT = 0.5, 200.0
"""Metres: shortest and longest width of a scene; chosen: a cupboard, and the largest halls."""
MAX_START_CELLS = 200_000
"""Chosen: a hall of 100 m by 125 m."""
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
    colours: bool = Field(
        True, description="Whether to show the colours of the file; false shows all in grey."
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
    _check_extent(vertices[np.unique(mesh.faces)], settings, source)
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
        mesh, colours, missing = load_coloured_mesh(file)
    except FileError as error:
        raise SceneError(f"{key} {settings.mesh!r} {error}") from None
    if missing and settings.colours:
        name, problem = next(iter(missing.items()))
        more = f" (and {len(missing) - 1} more)" if len(missing) > 1 else ""
        raise SceneError(
            f"{key} {settings.mesh!r} takes its colours from {name!r}, which {problem}{more}; or "
            "write colours: false to see the scene in grey"
        )
    return mesh, colours if settings.colours else None


def _check_extent(vertices: np.ndarray, settings: MeshScene, source: str) -> None:
    """Refuse a scene whose size makes no sense; `vertices` are in metres, z up."""
    width = float(np.ptp(vertices[:, :2], axis=0).max())
    shortest, longest = EXTENT
    if shortest <= width <= longest:
        return
    guesses = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "kilometres": 1000.0}
    unit = next(
        (name for name, factor in guesses.items() if 2 <= width * factor <= 60), "another unit"
    )
    remedy = f"set scale to {settings.scale * guesses[unit]:g}" if unit in guesses else "set scale"
    raise SceneError(
        f"{source}: scale: {settings.mesh!r} is {width:g} m wide with scale {settings.scale:g}; a "
        f"scene has {shortest:g} to {longest:g} m: if it is in {unit}, {remedy}"
    )


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
    level = np.abs(normals[:, 2]) > MIN_LEVEL_COSINE * 2 * areas
    heights, sizes, up = corners[level, :, 2].mean(1), areas[level], normals[level, 2] > 0
    lowest = _find_lowest_surface(heights, sizes)
    if lowest is None:
        return None
    # The lowest surface may be the underside of a slab, which has the floor on top. Faces of scans
    # look anywhere, so only a surface that looks up and is about as large is taken for it.
    above = up & (heights > lowest[0] - HEIGHT_BIN) & (heights < lowest[0] + MAX_SLAB)
    top = _find_lowest_surface(heights[above], sizes[above], lowest[1] / 2)
    return lowest[0] if top is None else top[0]


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
    cell = max(START_CELL, math.sqrt(float(np.prod(high - low)) / MAX_START_CELLS))
    x_centres, y_centres = (np.arange(low[k] + cell / 2, high[k], cell) for k in (0, 1))
    covered = np.zeros((len(x_centres), len(y_centres)), bool)
    for triangle in triangles:
        _cover(covered, x_centres, y_centres, triangle)
    half = cell / 2
    for i, j in zip(*np.nonzero(covered), strict=True):
        x, y = x_centres[i], y_centres[j]
        yield Area("floor", (float(x - half), float(x + half)), (float(y - half), float(y + half)))


def _cover(
    covered: np.ndarray, x_centres: np.ndarray, y_centres: np.ndarray, triangle: np.ndarray
) -> None:
    """Set the cells of a grid, bool (nx, ny), whose centres are in a triangle, float64 (3, 2)."""
    a, b, c = triangle.tolist()
    (left, bottom), (right, top) = triangle.min(0), triangle.max(0)
    i = slice(x_centres.searchsorted(left), x_centres.searchsorted(right, "right"))
    j = slice(y_centres.searchsorted(bottom), y_centres.searchsorted(top, "right"))
    x, y = x_centres[i, None], y_centres[None, j]
    if not (x.size and y.size):
        return
    first, second, third = (
        (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) for p, q in ((a, b), (b, c), (c, a))
    )
    covered[i, j] |= (first >= 0) & (second >= 0) & (third >= 0)
    covered[i, j] |= (first <= 0) & (second <= 0) & (third <= 0)


def _compute_normals(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (m, 3, 3) and normals (m, 3) of the faces; a normal is twice as long as the area."""
    corners = vertices[faces]
    return corners, np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _find_lowest_surface(
    heights: np.ndarray, areas: np.ndarray, min_area: float = MIN_FLOOR_AREA
) -> tuple[float, float] | None:
    """Mean height and area of the lowest bin with enough area of level faces."""
    order = np.argsort(heights, kind="stable")
    heights, areas = heights[order], areas[order]
    total = np.concatenate([[0.0], np.cumsum(areas)])
    for k in np.unique(np.floor(heights / HEIGHT_BIN).astype(np.int64)):
        middle = (k + 0.5) * HEIGHT_BIN
        first, last = np.searchsorted(heights, (middle - HEIGHT_BIN, middle + HEIGHT_BIN))
        if total[last] - total[first] >= max(min_area, MIN_FLOOR_AREA):
            near = slice(first, last)
            return float(np.average(heights[near], weights=areas[near])), float(areas[near].sum())
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
        return [Part(mesh, GREY, "plaster", two_sided=True)]
    levels = np.minimum((colours * COLOUR_LEVELS).astype(np.int64), COLOUR_LEVELS - 1)
    bins = levels @ (COLOUR_LEVELS * COLOUR_LEVELS, COLOUR_LEVELS, 1)
    order = np.argsort(bins, kind="stable")
    parts = []
    for chosen in np.split(order, np.flatnonzero(np.diff(bins[order])) + 1):
        colour = as_vector(float(c) for c in colours[chosen].mean(0))
        used, faces = np.unique(mesh.faces[chosen], return_inverse=True)
        faces = faces.reshape(-1, 3).astype(np.int32)
        part = Mesh(mesh.vertices[used], faces, mesh.uv[chosen])
        parts.append(Part(part, colour, two_sided=True))
    return parts
