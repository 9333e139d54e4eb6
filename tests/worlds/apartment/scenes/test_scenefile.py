"""Scene files: the shipped apartments are sound, and other files are refused."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pybullet
import pytest

from sensory_commutativity.worlds.apartment.scenes.scene import Scene, SceneError
from sensory_commutativity.worlds.apartment.scenes.scenefile import list_scene_files, load_scene
from sensory_commutativity.worlds.apartment.scenes.scenery import build_scenery
from tests.helpers import ROOT
from tests.worlds.apartment.scenes.examples import MESH, PLAN, write_scene


@pytest.fixture(scope="module")
def shipped() -> list[Scene]:
    return [load_scene(path) for path in sorted((ROOT / "config" / "apartments").glob("*.yaml"))]


@pytest.fixture
def client():
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(number)


def test_shipped_apartments_are_furnished_and_cheap_to_render(shipped):
    assert len(shipped) == 3
    for scene in shipped:
        assert len(scene.areas) >= 3, scene.name
        assert len(scene.fixtures) > 40, scene.name
        assert 12 <= len(scene.movables) <= 20, scene.name
        categories = {movable.category for movable in scene.movables}
        assert categories >= {"box", "can", "bottle", "mug", "ball", "bowl"}, scene.name
        parts = [part for fixture in scene.fixtures for part in fixture.parts]
        assert sum(len(part.mesh.faces) for part in parts) < 6_000, scene.name


def test_furniture_of_shipped_apartments_does_not_overlap(shipped, client):
    for scene in shipped:
        pybullet.resetSimulation(physicsClientId=client)
        names = [fixture.name for fixture in scene.fixtures]
        is_wall = ["wall" in name or "lintel" in name for name in names]
        bodies = build_scenery(client, scene).fixtures.items()
        for (body, i), (other, j) in combinations(bodies, 2):
            if i == j or (is_wall[i] and is_wall[j]):
                continue
            contacts = pybullet.getClosestPoints(body, other, 0.0, physicsClientId=client)
            distance = min((contact[8] for contact in contacts), default=0.0)
            assert distance > -0.02, f"{scene.name}: {names[i]} and {names[j]} overlap"


def test_objects_of_shipped_apartments_stay_where_they_are_placed(shipped, client):
    for scene in shipped:
        pybullet.resetSimulation(physicsClientId=client)
        scenery = build_scenery(client, scene)
        pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
        pybullet.setTimeStep(1 / 240, physicsClientId=client)
        for _ in range(720):
            pybullet.stepSimulation(physicsClientId=client)
        for body, movable in zip(scenery.movables, scene.movables, strict=True):
            position, _ = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            shift = np.linalg.norm(np.subtract(position, movable.position))
            assert shift < 0.006, f"{scene.name}: {movable.name} moved by {shift:.3f} m"


def test_a_file_that_is_no_scene_is_refused(tmp_path):
    with pytest.raises(SceneError, match="there is no such file"):
        load_scene(tmp_path / "scene.yaml")
    cases = {
        "a: [1": "not valid YAML in line",
        "3": "kind: expected",
        "kind: painting": "kind: expected floor-plan or mesh, got 'painting'",
    }
    for text, message in cases.items():
        with pytest.raises(SceneError, match=message):
            load_scene(write_scene(tmp_path, text))


def test_the_files_of_a_scene_include_its_mesh(tmp_path):
    plan = write_scene(tmp_path, PLAN)
    assert list_scene_files(plan) == [plan]
    mesh = write_scene(tmp_path, MESH)
    assert list_scene_files(mesh) == [mesh, tmp_path / "room.ply"]
