"""Public URDFs of installed packages load, or are told in one line with cause and remedy."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from sensory_commutativity.worlds.apartment.robots.urdf import RobotError
from sensory_commutativity.worlds.apartment.robots.urdf_reader import read_urdf
from sensory_commutativity.worlds.apartment.robots.visuals import load_shape_mesh

PACKAGES = ("pybullet_data", "mujoco", "gymnasium_robotics", "panda_gym")
LEAST_LOADED = 0.85
"""Share that must load; of the others, half are floors or scenes, and the rest lack a file."""
CAUSES = (
    "is of type 'spherical'", "which does not exist", "limits from", "finite numbers",
    "contains no links", "are known", "are these millimetres", "is in millimetres",
)  # fmt: skip


def list_urdfs() -> list[Path]:
    """The URDFs of installed packages, with one in fifty of the thousand random objects."""
    found = []
    for package in PACKAGES:
        spec = importlib.util.find_spec(package)
        for location in (spec.submodule_search_locations or []) if spec else []:
            found += sorted(Path(location).rglob("*.urdf"))
    random = [path for path in found if "random_urdfs" in path.parts]
    return [path for path in found if path not in random] + random[::50]


def test_public_urdfs_load_or_say_why_not():
    paths = list_urdfs()
    if len(paths) < 80:
        pytest.skip("needs pybullet_data")
    refused = []
    for path in paths:
        try:
            read_urdf(path)
        except RobotError as error:
            refused.append((path, str(error)))
    for path, message in refused:
        assert "\n" not in message and str(path.name) in message, message
        assert any(cause in message for cause in CAUSES), message
    assert len(refused) <= (1 - LEAST_LOADED) * len(paths), [path.name for path, _ in refused]


def test_the_meshes_of_public_robots_can_be_read():
    spec = importlib.util.find_spec("pybullet_data")
    folder = Path(spec.submodule_search_locations[0])
    for name in ("kuka_iiwa/model.urdf", "husky/husky.urdf", "r2d2.urdf", "racecar/racecar.urdf"):
        for link in read_urdf(folder / name).links.values():
            for shape in (*link.visuals, *link.collisions):
                if shape.kind == "mesh":
                    assert len(load_shape_mesh(shape).faces) > 3, name
