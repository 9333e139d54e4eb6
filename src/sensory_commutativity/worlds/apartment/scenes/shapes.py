"""Collision shapes as the files that PyBullet reads, made once and kept between processes.

Kept files lie in the user's cache folder (:func:`.folders.cache_folder`) under names that follow from what is in
them, so they never go stale, and any number of processes may make the same one at the same time.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ....storage.folders import cache_folder

MOST_HULL_POINTS = 64
"""Corners of a convex hull; chosen: the collision test's time grows with them, and 64 keep a robot's link to about 3 % of its size."""
THINNEST = 1e-3
"""Metres: what is flat is collided as if this thick; chosen: PyBullet's own collision margin of a URDF's shapes."""


def kept(kind: str, content: hashlib._Hash, make: Callable[[Path], None]) -> Path:
    """The folder `kind`-`content`; if there is none, `make` fills a temporary one that then takes its name."""
    folder = cache_folder("apartment", f"{kind}-{content.hexdigest()[:32]}")
    if folder.is_dir():
        return folder
    folder.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=".part-", dir=folder.parent))
    try:
        make(temporary)
        os.rename(temporary, folder)
    except OSError:
        if not folder.is_dir():  # unless another process was first
            raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return folder


def hull_points(points: np.ndarray, most: int = MOST_HULL_POINTS) -> np.ndarray:
    """Corners of the convex hull of `points`, float64 (n, 3): at most `most`, those farthest in evenly spread directions if it has more."""
    points = np.unique(np.asarray(points, np.float64), axis=0)
    try:
        corners = points[np.sort(ConvexHull(points).vertices)]
    except (QhullError, ValueError):  # flat, or too few
        low, high = points.min(0) - THINNEST / 2, points.max(0) + THINNEST / 2
        return np.array(
            [
                [x, y, z]
                for x in (low[0], high[0])
                for y in (low[1], high[1])
                for z in (low[2], high[2])
            ]
        )
    if len(corners) <= most:
        return corners
    turn = np.arange(most) * np.pi * (1 + 5**0.5)  # a Fibonacci spiral on the sphere
    z = 1 - (2 * np.arange(most) + 1) / most
    directions = np.stack(
        [np.cos(turn) * np.sqrt(1 - z * z), np.sin(turn) * np.sqrt(1 - z * z), z], 1
    )
    return corners[np.unique((corners @ directions.T).argmax(0))]


def write_points(path: Path, points: np.ndarray) -> None:
    """An OBJ file that PyBullet reads as the convex hull of `points`, float64 (n, 3).

    PyBullet takes the corners of all faces, each as often as it occurs, so every point is in one face only (the last face repeats some).
    """
    order = np.resize(np.arange(len(points)), 3 * -(-len(points) // 3)).reshape(-1, 3)
    write_triangles(path, points, order)


def write_triangles(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    """An OBJ file of triangles: float64 (n, 3) and int (m, 3)."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices, np.float64).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (np.asarray(faces) + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def shape_file(vertices: np.ndarray, faces: np.ndarray | None = None) -> Path:
    """A kept OBJ file of the convex hull of `vertices`, float64 (n, 3), or with `faces`, int32 (m, 3), of these triangles."""
    content = hashlib.sha256(b"1")  # the format's version
    content.update(np.ascontiguousarray(vertices, np.float64).tobytes())
    content.update(b"" if faces is None else np.ascontiguousarray(faces, np.int32).tobytes())

    def make(folder: Path) -> None:
        if faces is None:
            write_points(folder / "shape.obj", hull_points(vertices))
        else:
            write_triangles(folder / "shape.obj", vertices, faces)

    return kept("shape", content, make) / "shape.obj"
