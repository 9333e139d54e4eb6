"""Triangle meshes: primitives and solids of revolution.

All lengths are in metres. Faces are counter-clockwise seen from outside. Textures repeat once per
metre on boxes and on meshes from files, whatever their size, so a floor tile has the same size
everywhere; round shapes carry a texture once around.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from . import frames as fr
from .scenes.scene import UPRIGHT, Mesh, Quaternion, Vector

_UV_END = 0.999  # just below 1, where the next repetition of a texture begins

# The sides of a box: its corners (numbered as in `box`) in order around it, and the two axes along
# which the texture runs, across and up.
_BOX_SIDES = (
    ((0, 1, 3, 2), 1, 2),
    ((4, 6, 7, 5), 1, 2),
    ((0, 4, 5, 1), 0, 2),
    ((2, 3, 7, 6), 0, 2),
    ((0, 2, 6, 4), 0, 1),
    ((1, 5, 7, 3), 0, 1),
)

# ---- primitives ------------------------------------------------------------------------------


def box(half: Sequence[float], repeat: float = 1.0) -> Mesh:
    """Return a box centred on the origin.

    Parameters
    ----------
    half : sequence of float
        Half the size along x, y and z, metres.
    repeat : float
        Repetitions of the texture per metre.
    """
    signs = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    corners = np.array(signs, np.float64) * np.asarray(half, np.float64)  # (8, 3)
    faces, uv = [], []
    for ring, across, up in _BOX_SIDES:
        at = [(corners[i, across] * repeat, -corners[i, up] * repeat) for i in ring]
        faces += [(ring[0], ring[1], ring[2]), (ring[0], ring[2], ring[3])]
        uv += [(at[0], at[1], at[2]), (at[0], at[2], at[3])]
    return Mesh(corners, np.array(faces, np.int32), np.array(uv, np.float32))


def panel(half: Sequence[float]) -> Mesh:
    """Return a :func:`box` of which every side carries the texture exactly once.

    For pictures, screens and the spines of books.
    """
    mesh = box(half)
    low, high = mesh.uv.min(axis=1, keepdims=True), mesh.uv.max(axis=1, keepdims=True)
    return replace(mesh, uv=((mesh.uv - low) / (high - low) * _UV_END).astype(np.float32))


def lathe(profile: Sequence[tuple[float, float]], sides: int = 16) -> Mesh:
    """Return a solid of revolution about the z axis.

    Parameters
    ----------
    profile : sequence of (radius, z)
        The outline, metres, from its lowest point on the axis to its highest, with the outside on
        the right hand. Points on the axis have radius 0. The profile of a bowl continues over the
        rim and down the inside.
    sides : int
        Segments around the axis.
    """
    angles = np.arange(sides) * (2 * math.pi / sides)
    circle = np.stack([np.cos(angles), np.sin(angles)], 1)  # (sides, 2)
    vertices: list[tuple[float, float, float]] = []
    starts = []  # the first vertex of each profile point
    for radius, z in profile:
        starts.append(len(vertices))
        if radius > 0:
            vertices += [(radius * x, radius * y, z) for x, y in circle]
        else:
            vertices.append((0.0, 0.0, z))
    segments = [math.dist(a, b) for a, b in itertools.pairwise(profile)]
    lengths = np.concatenate([[0], np.cumsum(segments)])
    faces, uv = [], []
    for k in range(len(profile) - 1):
        low, high = lengths[k] / lengths[-1] * _UV_END, lengths[k + 1] / lengths[-1] * _UV_END
        lower_open, upper_open = profile[k][0] > 0, profile[k + 1][0] > 0  # off the axis
        for i in range(sides):
            j, u, w = (i + 1) % sides, i / sides, (i + 1) / sides
            a, b = starts[k] + i * lower_open, starts[k] + j * lower_open
            d, c = starts[k + 1] + i * upper_open, starts[k + 1] + j * upper_open
            if lower_open:
                faces.append((a, b, c))
                uv.append(((u, -low), (w, -low), (w, -high)))
            if upper_open:
                faces.append((a, c, d))
                uv.append(((u, -low), (w, -high), (u, -high)))
    return Mesh(np.array(vertices, np.float64), np.array(faces, np.int32), np.array(uv, np.float32))


def cylinder(radius: float, half_height: float, sides: int = 16) -> Mesh:
    """Return an upright cylinder centred on the origin."""
    bottom, top = -half_height, half_height
    return lathe([(0.0, bottom), (radius, bottom), (radius, top), (0.0, top)], sides)


def capsule(radius: float, half_height: float, rings: int = 8, sides: int = 12) -> Mesh:
    """Return an upright cylinder with round caps, which add `radius` at both ends."""
    angles = np.linspace(-math.pi / 2, 0, rings // 2 + 1)[1:]
    lower = [(radius * math.cos(a), radius * math.sin(a) - half_height) for a in angles]
    upper = [(r, -z) for r, z in reversed(lower)]
    end = half_height + radius
    return lathe([(0.0, -end), *lower, *upper, (0.0, end)], sides)


def sphere(radius: float, rings: int = 8, sides: int = 12) -> Mesh:
    """Return a sphere centred on the origin."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)
    between = [(radius * math.cos(a), radius * math.sin(a)) for a in angles[1:-1]]
    return lathe([(0.0, -radius), *between, (0.0, radius)], sides)


def handle(radius: float, thickness: float, bends: int = 8, sides: int = 5) -> Mesh:
    """Return half a torus in the x-z plane, open towards negative x: the handle of a mug.

    Parameters
    ----------
    radius : float
        Of the bow, from its centre to the middle of the rod, metres.
    thickness : float
        Diameter of the rod, metres.
    bends, sides : int
        Segments along the bow and around the rod.
    """
    bend = np.linspace(-math.pi / 2, math.pi / 2, bends + 1)
    around = np.arange(sides) * (2 * math.pi / sides)
    out = radius + thickness / 2 * np.cos(around)
    vertices = np.array(
        [
            (r * math.cos(b), thickness / 2 * math.sin(a), r * math.sin(b))
            for b in bend
            for a, r in zip(around, out, strict=True)
        ]
    )
    faces = []
    for k in range(bends):
        for i in range(sides):
            j = (i + 1) % sides
            a, b, c, d = k * sides + i, k * sides + j, (k + 1) * sides + j, (k + 1) * sides + i
            faces += [(a, b, c), (a, c, d)]
    last = bends * sides
    first_cap = [(0, i + 1, i) for i in range(1, sides - 1)]
    last_cap = [(last, last + i, last + i + 1) for i in range(1, sides - 1)]
    return project_texture(vertices, np.array([*faces, *first_cap, *last_cap]))


# ---- operations ------------------------------------------------------------------------------


def transform(mesh: Mesh, position: Vector, rotation: Quaternion = UPRIGHT) -> Mesh:
    """Return the mesh rotated by `rotation` and then moved by `position`."""
    return replace(mesh, vertices=fr.apply(fr.from_quaternion(position, rotation), mesh.vertices))


def scale(mesh: Mesh, factors: Sequence[float]) -> Mesh:
    """Return the mesh stretched along x, y and z by positive factors."""
    return replace(mesh, vertices=mesh.vertices * np.asarray(factors, np.float64))


def concatenate(meshes: Sequence[Mesh]) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(faces).astype(np.int32),
        np.concatenate([mesh.uv for mesh in meshes]),
    )


def volume(mesh: Mesh) -> float:
    """Return the signed volume of a closed mesh, cubic metres: positive for outward faces."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def project_texture(vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    """Return the mesh with texture coordinates in metres.

    The texture of each triangle is projected along the axis to which it is most nearly
    perpendicular.
    """
    faces = np.ascontiguousarray(faces, np.int32)
    corners = vertices[faces]  # (m, 3 corners, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    projected = np.array([(1, 2), (0, 2), (0, 1)])[np.abs(normals).argmax(1)]  # (m, 2) axes
    uv = np.take_along_axis(corners, projected[:, None, :].repeat(3, 1), 2) * (1, -1)
    return Mesh(np.asarray(vertices, np.float64), faces, uv.astype(np.float32))
