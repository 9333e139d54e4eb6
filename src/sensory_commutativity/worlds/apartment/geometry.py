"""Meshes: boxes, cylinders, spheres, solids of revolution, handles, and what is read from files.

All lengths are metres. Faces are counter-clockwise seen from outside. Textures repeat once per metre on boxes and meshes from files, whatever their
size, so that a tile is a tile everywhere; round shapes carry a texture once around.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from . import frames as fr
from .scenes.scene import UPRIGHT, Mesh, Quaternion, Vector


def box(half: Sequence[float], repeat: float = 1.0) -> Mesh:
    """A box around the origin with half sizes `half`; the texture repeats `repeat` times per metre."""
    corners = np.array(
        [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64
    ) * np.asarray(half, np.float64)
    # Sides, each with its corners in order around it and the axes that its texture runs along.
    sides = (
        ((0, 1, 3, 2), 1, 2), ((4, 6, 7, 5), 1, 2), ((0, 4, 5, 1), 0, 2), ((2, 3, 7, 6), 0, 2), ((0, 2, 6, 4), 0, 1), ((1, 5, 7, 3), 0, 1),
    )  # fmt: skip
    faces, uv = [], []
    for ring, across, up in sides:
        at = [(corners[i, across] * repeat, -corners[i, up] * repeat) for i in ring]
        faces += [(ring[0], ring[1], ring[2]), (ring[0], ring[2], ring[3])]
        uv += [(at[0], at[1], at[2]), (at[0], at[2], at[3])]
    return Mesh(corners, np.array(faces, np.int32), np.array(uv, np.float32))


def panel(half: Sequence[float]) -> Mesh:
    """As :func:`box`, but every side carries a texture exactly once: pictures, screens, the spines of books."""
    mesh = box(half)
    low, high = mesh.uv.min(axis=1, keepdims=True), mesh.uv.max(axis=1, keepdims=True)
    return replace(
        mesh, uv=((mesh.uv - low) / (high - low) * 0.999).astype(np.float32)
    )  # 1 would already be the next repetition


def lathe(profile: Sequence[tuple[float, float]], sides: int = 16) -> Mesh:
    """A solid of revolution about z.

    Parameters
    ----------
    profile : sequence of (radius, z)
        The outline from its lowest point on the axis to its highest, the outside on the right hand; points on the axis have radius 0. A bowl goes on
        over its rim and down inside.
    """
    angles = np.arange(sides) * (2 * math.pi / sides)
    ring = np.stack([np.cos(angles), np.sin(angles)], 1)
    vertices, starts = [], []
    for radius, z in profile:
        starts.append(len(vertices))
        around = [(radius * x, radius * y, z) for x, y in ring] if radius > 0 else [(0.0, 0.0, z)]
        vertices += around
    faces, uv = [], []
    lengths = np.concatenate(
        [[0], np.cumsum([math.dist(a, b) for a, b in itertools.pairwise(profile)])]
    )
    for k in range(len(profile) - 1):
        low, high = lengths[k] / lengths[-1] * 0.999, lengths[k + 1] / lengths[-1] * 0.999
        for i in range(sides):
            j, u, w = (i + 1) % sides, i / sides, (i + 1) / sides
            a, b = (
                (starts[k] + (i if profile[k][0] > 0 else 0)),
                (starts[k] + (j if profile[k][0] > 0 else 0)),
            )
            d, c = (
                (starts[k + 1] + (i if profile[k + 1][0] > 0 else 0)),
                (starts[k + 1] + (j if profile[k + 1][0] > 0 else 0)),
            )
            if profile[k][0] > 0:
                faces.append((a, b, c))
                uv.append(((u, -low), (w, -low), (w, -high)))
            if profile[k + 1][0] > 0:
                faces.append((a, c, d))
                uv.append(((u, -low), (w, -high), (u, -high)))
    return Mesh(np.array(vertices, np.float64), np.array(faces, np.int32), np.array(uv, np.float32))


def cylinder(radius: float, half_height: float, sides: int = 16) -> Mesh:
    """An upright cylinder around the origin."""
    return lathe(
        [(0.0, -half_height), (radius, -half_height), (radius, half_height), (0.0, half_height)],
        sides,
    )


def sphere(radius: float, rings: int = 8, sides: int = 12) -> Mesh:
    """A ball around the origin."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)
    inner = [(radius * math.cos(a), radius * math.sin(a)) for a in angles[1:-1]]
    return lathe([(0.0, -radius), *inner, (0.0, radius)], sides)


def handle(radius: float, thickness: float, bows: int = 8, sides: int = 5) -> Mesh:
    """Half a torus in the x-z plane, open towards negative x: the handle of a mug. `radius` is the bow's, `thickness` that of the rod."""
    bend, around = (
        np.linspace(-math.pi / 2, math.pi / 2, bows + 1),
        np.arange(sides) * (2 * math.pi / sides),
    )
    out = radius + thickness / 2 * np.cos(around)
    vertices = np.array(
        [
            (r * math.cos(b), thickness / 2 * math.sin(a), r * math.sin(b))
            for b in bend
            for a, r in zip(around, out, strict=True)
        ]
    )
    faces = []
    for k in range(bows):
        for i in range(sides):
            j = (i + 1) % sides
            a, b, c, d = k * sides + i, k * sides + j, (k + 1) * sides + j, (k + 1) * sides + i
            faces += [(a, b, c), (a, c, d)]
    ends = (
        [(0, i + 1, i) for i in range(1, sides - 1)],
        [(bows * sides, bows * sides + i, bows * sides + i + 1) for i in range(1, sides - 1)],
    )
    return _plain(vertices, np.array([*faces, *ends[0], *ends[1]]))


def placed(mesh: Mesh, position: Vector, rotation: Quaternion = UPRIGHT) -> Mesh:
    """The mesh moved by `position` after being turned by `rotation`."""
    return replace(mesh, vertices=fr.apply(fr.from_quaternion(position, rotation), mesh.vertices))


def scaled(mesh: Mesh, factors: Sequence[float]) -> Mesh:
    """The mesh stretched along x, y and z by positive factors."""
    return replace(mesh, vertices=mesh.vertices * np.asarray(factors, np.float64))


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(
            [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
        ).astype(np.int32),
        np.concatenate([mesh.uv for mesh in meshes]),
    )


def coloured_from_file(path: Path) -> tuple[Mesh, np.ndarray | None]:
    """A mesh file as :func:`from_file` reads it, and the colour of every face, float64 (m, 3), from vertices, faces or textures; None where it
    has none."""
    read = _read(path)
    try:
        visual = read.visual.to_color() if read.visual.kind == "texture" else read.visual
        colours = (
            None if visual.kind is None else np.asarray(visual.face_colors, np.float64)[:, :3] / 255
        )
    except (AttributeError, ValueError, IndexError):  # textures that are not there or not readable
        colours = None
    return _plain(np.asarray(read.vertices, np.float64), np.asarray(read.faces, np.int64)), colours


def from_file(path: Path, max_faces: int | None = None) -> Mesh:
    """A mesh file as trimesh reads it, all its drawables as one; `max_faces` thins it out to about so many triangles.

    Raises whatever trimesh raises for a file that it cannot read, and ValueError for one without triangles.
    """
    import fast_simplification

    read = _read(path)
    vertices, faces = np.asarray(read.vertices, np.float64), np.asarray(read.faces, np.int64)
    if max_faces is not None and len(faces) > max_faces:
        thin_vertices, thin_faces = fast_simplification.simplify(
            vertices.astype(np.float32), faces.astype(np.int32), target_count=max_faces
        )
        vertices, faces = np.asarray(thin_vertices, np.float64), np.asarray(thin_faces, np.int64)
    return _plain(vertices, faces)


def _read(path: Path):
    import trimesh

    read = trimesh.load(path, force="mesh", process=True)
    if len(getattr(read, "faces", ())) == 0:
        raise ValueError("it holds no triangles")
    read.merge_vertices(merge_tex=True, merge_norm=True)
    return read


def volume(mesh: Mesh) -> float:
    """Signed volume of a closed mesh, cubic metres: positive if its faces are counter-clockwise seen from outside."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def _plain(vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    """A mesh whose texture is laid on along the two axes that each triangle faces least."""
    faces = np.ascontiguousarray(faces, np.int32)
    corners = vertices[faces]
    facing = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).argmax(
        1
    )
    along = np.array([(1, 2), (0, 2), (0, 1)])[facing]
    uv = np.take_along_axis(corners, along[:, None, :].repeat(3, 1), 2) * (1, -1)
    return Mesh(np.asarray(vertices, np.float64), faces, uv.astype(np.float32))
