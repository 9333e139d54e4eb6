"""Scene files and meshes for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import yaml

PLAN: dict[str, Any] = {
    "kind": "floor-plan",
    "name": "flat",
    "rooms": {"one": {"x": [0, 4], "y": [0, 3]}, "two": {"x": [4, 7], "y": [0, 3]}},
    "doors": [{"at": [4, 1.5], "width": 1.0}],
    "furniture": [
        {"type": "table", "name": "desk", "at": [1, 1], "heading": 90},
        {"type": "wardrobe", "at": [3, 0.4], "heading": 90},
    ],
    "objects": [
        {"type": "mug", "stands_on": "desk", "at": [0.2, 0.3]},
        {"type": "football", "at": [2, 2]},
    ],
}
"""Two furnished rooms with a door between them."""

MESH: dict[str, Any] = {"kind": "mesh", "name": "mine", "mesh": "room.ply"}
"""A scene of the mesh file room.ply."""


def write_scene(folder: Path, settings: dict[str, Any] | str) -> Path:
    """Write a scene file, from settings or as text; return its path."""
    text = settings if isinstance(settings, str) else yaml.safe_dump(settings)
    (folder / "scene.yaml").write_text(text)
    return folder / "scene.yaml"


def box_mesh(size: tuple[float, ...], position: tuple[float, ...]) -> trimesh.Trimesh:
    """Return a box with edges `size`, metres, around `position`."""
    return trimesh.creation.box(size, trimesh.transformations.translation_matrix(position))


def room_mesh(up: str = "z") -> trimesh.Trimesh:
    """Return a room of 4 m x 3 m with a table: red walls, a blue floor at height -1.3 m."""
    walls = [((4, 0.1, 2.4), (0, y, 1.2)) for y in (1.5, -1.5)]
    walls += [((0.1, 3, 2.4), (x, 0, 1.2)) for x in (2, -2)]
    table, floor = ((0.4, 0.4, 0.7), (1, 1, 0.35)), ((4, 3, 0.1), (0, 0, -0.05))
    parts = [box_mesh(size, (x, y, z - 1.3)) for size, (x, y, z) in [*walls, table, floor]]
    for part in parts:
        part.visual.face_colors = (
            [200, 30, 30, 255] if part is not parts[-1] else [30, 30, 200, 255]
        )
    mesh = trimesh.util.concatenate(parts)
    if up == "y":
        mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, (1, 0, 0)))
    return mesh
