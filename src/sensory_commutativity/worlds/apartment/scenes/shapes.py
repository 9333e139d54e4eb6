"""Collision shapes as OBJ files for PyBullet, cached between processes.

Cached files are in the user's cache folder (:func:`....storage.folders.cache_folder`) under names
derived from what they are made of. They never go stale, and several processes may write the same
one at the same time. Beside them are their hashes, which are checked whenever they are used: files
that are damaged are made again.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ....storage.folders import cache_folder
from ....storage.hashing import sha256

HASHES = "hashes.json"
"""Name of the file of hashes in a cache folder."""

MAX_HULL_POINTS = 64
"""Vertices of a convex hull; chosen: collision time grows with them, and with 64 the hull of a
robot link keeps its size to within about 3 %."""
MIN_THICKNESS = 1e-3
"""Metres: thickness at which flat shapes collide; chosen: PyBullet's own collision margin of the
shapes of a URDF."""


def ensure_cached(kind: str, content: hashlib._Hash, build: Callable[[Path], None]) -> Path:
    """Return the cache folder of some content, and build it first if it does not exist.

    Parameters
    ----------
    kind : str
        Prefix of the folder's name.
    content : hash object
        Hash of everything that the files depend on.
    build : callable
        Writes the files into a temporary folder, which is then renamed.
    """
    folder = cache_folder("apartment", f"{kind}-{content.hexdigest()[:32]}")
    if _is_intact(folder):
        return folder
    _remove(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=".part-", dir=folder.parent))
    try:
        build(temporary)
        hashes = {path.name: sha256(path) for path in sorted(temporary.iterdir())}
        written = json.dumps({"folder": folder.name, "files": hashes})
        (temporary / HASHES).write_text(written, encoding="utf-8")
        os.rename(temporary, folder)
    except OSError:
        if not _is_intact(folder):  # unless another process was faster
            raise
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return folder


def _is_intact(folder: Path) -> bool:
    """Whether a cache folder holds exactly the files that were written, unchanged."""
    try:
        written = json.loads((folder / HASHES).read_bytes())
        hashes, names = written["files"], {path.name for path in folder.iterdir()} - {HASHES}
        return (
            written["folder"] == folder.name
            and names == set(hashes)
            and all(sha256(folder / name) == expected for name, expected in hashes.items())
        )
    except (OSError, ValueError, LookupError, AttributeError, TypeError):
        return False


def _remove(folder: Path) -> None:
    """Remove a damaged cache folder; at once for other processes, which may do the same."""
    if folder.is_symlink() or folder.is_file():
        folder.unlink(missing_ok=True)
    elif folder.exists():
        try:
            rubbish = tempfile.mkdtemp(prefix=".part-", dir=folder.parent)
            os.rename(folder, Path(rubbish, "damaged"))
        except FileNotFoundError:
            return
        shutil.rmtree(rubbish, ignore_errors=True)


def compute_hull_points(points: np.ndarray, max_points: int = MAX_HULL_POINTS) -> np.ndarray:
    """Return at most `max_points` vertices of a convex hull.

    A larger hull is reduced to its extreme vertices in evenly spread directions. Flat points give
    the corners of their bounding box, at least MIN_THICKNESS thick.

    Parameters
    ----------
    points : float64 (n, 3)

    Returns
    -------
    float64 (m, 3)
    """
    points = np.unique(np.asarray(points, np.float64), axis=0)
    try:
        corners = points[np.sort(ConvexHull(points).vertices)]
    except (QhullError, ValueError):  # flat, or fewer than four points
        low, high = points.min(0) - MIN_THICKNESS / 2, points.max(0) + MIN_THICKNESS / 2
        return np.array(list(product(*zip(low, high, strict=True))))
    if len(corners) <= max_points:
        return corners
    angle = np.arange(max_points) * np.pi * (1 + 5**0.5)  # a Fibonacci spiral on the sphere
    z = 1 - (2 * np.arange(max_points) + 1) / max_points
    radius = np.sqrt(1 - z * z)
    directions = np.stack([np.cos(angle) * radius, np.sin(angle) * radius, z], 1)
    return corners[np.unique((corners @ directions.T).argmax(0))]


def write_hull_obj(path: Path, points: np.ndarray) -> None:
    """Write an OBJ file that PyBullet reads as the convex hull of `points`, float64 (n, 3).

    PyBullet collects the corners of all faces with repetitions, so each point occurs in one face
    only (except that the last face is filled up).
    """
    order = np.resize(np.arange(len(points)), 3 * -(-len(points) // 3)).reshape(-1, 3)
    write_triangles_obj(path, points, order)


def write_triangles_obj(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    """Write triangles to an OBJ file: float64 (n, 3) and int (m, 3)."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices, np.float64).tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (np.asarray(faces) + 1).tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def write_shape(vertices: np.ndarray, faces: np.ndarray | None = None) -> Path:
    """Return a cached OBJ file of triangles, or of a convex hull if `faces` is None.

    Parameters
    ----------
    vertices : float64 (n, 3)
    faces : int32 (m, 3), optional
    """
    content = hashlib.sha256(b"1")  # version of the format
    content.update(np.ascontiguousarray(vertices, np.float64).tobytes())
    content.update(b"" if faces is None else np.ascontiguousarray(faces, np.int32).tobytes())

    def build(folder: Path) -> None:
        if faces is None:
            write_hull_obj(folder / "shape.obj", compute_hull_points(vertices))
        else:
            write_triangles_obj(folder / "shape.obj", vertices, faces)

    return ensure_cached("shape", content, build) / "shape.obj"
