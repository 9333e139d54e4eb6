"""Apartments: the three that come with the project are sound; a user's own plan or mesh loads, or is refused in one clear line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pybullet
import pytest
import trimesh
import yaml

from sensory_commutativity.worlds.apartment.scenes.furniture import FURNITURE
from sensory_commutativity.worlds.apartment.scenes.meshscene import floor_height
from sensory_commutativity.worlds.apartment.scenes.objects import FAMILIES, OBJECTS, list_object_types
from sensory_commutativity.worlds.apartment.scenes.scene import Scene, SceneError
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene
from sensory_commutativity.worlds.apartment.scenes.scenery import build_scenery

CONFIG = Path(__file__).parents[2] / "config"
SHIPPED = sorted((CONFIG / "apartments").glob("*.yaml"))
PLAN = {
    "kind": "floor-plan", "name": "flat",
    "rooms": {"one": {"x": [0, 4], "y": [0, 3]}, "two": {"x": [4, 7], "y": [0, 3]}},
    "doors": [{"at": [4, 1.5], "width": 1.0}],
    "furniture": [{"type": "table", "name": "desk", "at": [1, 1], "heading": 90}, {"type": "wardrobe", "at": [3, 0.4], "heading": 90}],
    "objects": [{"type": "mug", "stands_on": "desk", "at": [0.2, 0.3]}, {"type": "football", "at": [2, 2]}],
}  # fmt: skip


def written(tmp_path: Path, settings) -> Path:
    (tmp_path / "scene.yaml").write_text(
        settings if isinstance(settings, str) else yaml.safe_dump(settings)
    )
    return tmp_path / "scene.yaml"


@pytest.fixture
def client():
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(number)


@pytest.fixture(scope="module", params=SHIPPED, ids=lambda path: path.stem)
def shipped(request) -> Scene:
    return load_scene(request.param)


def test_three_apartments_are_shipped():
    assert [path.stem for path in SHIPPED] == ["bolton-stand-in", "placida-stand-in", "rs-stand-in"]


def test_a_shipped_apartment_is_furnished(shipped):
    assert (
        len(shipped.areas) >= 3 and 12 <= len(shipped.movables) <= 20 and len(shipped.fixtures) > 40
    )
    assert (
        sum(len(part.mesh.faces) for fixture in shipped.fixtures for part in fixture.parts) < 6_000
    )
    assert {movable.category for movable in shipped.movables} >= {
        "box",
        "can",
        "bottle",
        "mug",
        "ball",
        "bowl",
    }


def test_furniture_of_a_shipped_apartment_does_not_overlap(shipped, client):
    bodies = list(build_scenery(client, shipped).fixtures.items())
    names = [fixture.name for fixture in shipped.fixtures]
    built = ("wall", "lintel")
    for i, (body, fixture) in enumerate(bodies):
        for other, other_fixture in bodies[i + 1 :]:
            if fixture == other_fixture or all(
                any(word in names[f] for word in built) for f in (fixture, other_fixture)
            ):
                continue
            depth = min(
                (
                    point[8]
                    for point in pybullet.getClosestPoints(body, other, 0.0, physicsClientId=client)
                ),
                default=0.0,
            )
            assert depth > -0.02, (
                f"{names[fixture]} and {names[other_fixture]} overlap by {-depth:.3f} m"
            )


def test_objects_of_a_shipped_apartment_stay_where_they_are_put(shipped, client):
    scenery = build_scenery(client, shipped)
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    pybullet.setTimeStep(1 / 240, physicsClientId=client)
    for _ in range(720):
        pybullet.stepSimulation(physicsClientId=client)
    for body, movable in zip(scenery.movables, shipped.movables, strict=True):
        moved = np.linalg.norm(
            np.subtract(
                pybullet.getBasePositionAndOrientation(body, physicsClientId=client)[0],
                movable.position,
            )
        )
        assert moved < 0.006, f"{movable.name} moved by {moved:.3f} m"


def test_families_are_disjoint_and_of_real_sizes():
    training, testing = (set(list_object_types(family)) for family in FAMILIES)
    assert (
        training | testing == set(OBJECTS)
        and not training & testing
        and min(len(training), len(testing)) >= 8
    )
    for kind, what in OBJECTS.items():
        vertices = np.concatenate([part.mesh.vertices for part in what.parts])
        size = np.ptp(vertices, axis=0)
        assert 0.03 < size.max() < 0.5 and 0.1 <= what.mass <= 4, kind
        assert vertices[:, 2].min() == pytest.approx(-what.half_height, abs=1e-3), kind
        assert what.mass / size.prod() < 2_500, kind  # kg per cubic metre: lighter than stone


@pytest.mark.parametrize("kind", FURNITURE)
def test_furniture_stands_within_its_size(kind):
    what = FURNITURE[kind]
    blocks = what.build(what.size, what.colour, what.texture)
    half = np.array(
        [
            (*block.size[:1], *block.size[:1], block.size[1])
            if block.kind == "cylinder"
            else block.size
            for block in blocks
        ]
    )
    middle = np.array([block.middle for block in blocks])
    low, high = (middle - half).min(0), (middle + half).max(0)
    assert (
        (half > 0).all()
        and (high[:2] <= np.array(what.size[:2]) / 2 + 0.06).all()
        and (low[:2] >= -np.array(what.size[:2]) / 2 - 0.06).all()
    )
    assert low[2] >= -0.13 and (
        kind in ("rug", "picture", "window") or any(block.solid for block in blocks)
    )


def test_a_plan_becomes_walls_a_door_furniture_and_things(tmp_path):
    scene = load_scene(written(tmp_path, PLAN))
    names = [fixture.name for fixture in scene.fixtures]
    assert {
        "one floor",
        "two ceiling",
        "one east wall 1",
        "one east wall 2",
        "one east lintel 1",
        "two west lintel 1",
        "desk",
        "wardrobe-2",
    } <= set(names)
    assert [(area.name, area.x) for area in scene.areas] == [
        ("one", (0.06, 3.94)),
        ("two", (4.06, 6.94)),
    ]
    mug, ball = scene.movables
    assert mug.position == pytest.approx(
        (1 - 0.3, 1 + 0.2, 0.74 + 0.0475 + 0.001)
    ) and ball.position == pytest.approx((2, 2, 0.111))
    west = next(fixture for fixture in scene.fixtures if fixture.name == "two west wall 1")
    assert west.solids[0].position == pytest.approx((4.03, 0.5, 1.25)) and west.solids[
        0
    ].size == pytest.approx((0.03, 0.5, 1.25))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rooms": {}}, "there is no floor to stand on"),
        ({"rooms": {"one": {"x": [0, 4], "y": [0, 3]}, "two": {"x": [3, 7], "y": [0, 3]}}}, "'one' and 'two' overlap"),
        ({"rooms": {"one": {"x": [4, 0], "y": [0, 3]}}}, "rooms.one.x: from 4 to 0 is no room"),
        ({"rooms": {"one": {"x": [0, 4], "y": [0, 3], "floor": "lava"}}, "doors": []}, "there is no texture 'lava'"),
        ({"doors": [{"at": [2, 1.5]}]}, r"doors\[0\]: no wall between two rooms"),
        ({"doors": [{"at": [0, 1.5]}]}, r"doors\[0\]: no wall between two rooms"),
        ({"doors": [{"at": [4, 1.5], "height": 2.5}]}, "does not fit under the ceiling"),
        ({"furniture": [{"type": "throne", "at": [1, 1]}]}, "there is no type 'throne'; choose among table, "),
        ({"furniture": [{"type": "table", "at": [9, 1]}], "objects": []}, "is in no room"),
        ({"furniture": [{"type": "table", "name": "t", "at": [1, 1]}, {"type": "bed", "name": "t", "at": [3, 1]}]}, "two are called 't'"),
        ({"objects": [{"type": "anvil", "at": [1, 1]}]}, "there is no type 'anvil'; choose among cereal-box"),
        ({"objects": [{"type": "mug", "stands_on": "shelf", "at": [0, 0]}]}, "stands on 'shelf', which is no furniture"),
        ({"objects": [{"type": "mug", "stands_on": "wardrobe-2", "at": [0, 0]}]}, "nothing can stand on 'wardrobe-2'; choose among desk"),
        ({"kind": "painting"}, "kind: expected floor-plan or mesh, got 'painting'"),
        ({"colour": "red"}, "colour"),
    ],
)  # fmt: skip
def test_a_plan_that_makes_no_sense_is_refused_in_one_line(tmp_path, change, message):
    with pytest.raises(SceneError, match=message) as error:
        load_scene(written(tmp_path, {**PLAN, **change}))
    assert str(error.value).startswith(str(tmp_path / "scene.yaml")) and "\n" not in str(
        error.value
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [("a: [1", "not valid YAML in line"), ("3", "kind: expected"), (None, "there is no such file")],
)
def test_a_file_that_is_no_scene_is_refused(tmp_path, text, message):
    path = tmp_path / "scene.yaml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(SceneError, match=message):
        load_scene(path)


# ---- meshes ----------------------------------------------------------------------------------------------------------------------


def room_mesh(floor: bool = True) -> trimesh.Trimesh:
    """Four walls and a table, with a floor or without, 4 m x 3 m; the floor is at z = -1.3."""
    boxes = [((4, 0.1, 2.4), (0, y, 1.2)) for y in (1.5, -1.5)] + [
        ((0.1, 3, 2.4), (x, 0, 1.2)) for x in (2, -2)
    ]
    boxes.append(((0.4, 0.4, 0.7), (1, 1, 0.35)))
    if floor:
        boxes.append(((4, 3, 0.1), (0, 0, -0.05)))
    parts = [
        trimesh.creation.box(size, trimesh.transformations.translation_matrix((x, y, z - 1.3)))
        for size, (x, y, z) in boxes
    ]
    for part, colour in zip(parts, ([200, 30, 30, 255],) * 5 + ([30, 30, 200, 255],), strict=False):
        part.visual.face_colors = colour
    return trimesh.util.concatenate(parts)


@pytest.mark.parametrize("up", ["z", "y"])
@pytest.mark.parametrize("suffix", ["ply", "glb", "obj", "stl"])
def test_a_users_own_mesh_becomes_a_scene(tmp_path, suffix, up):
    mesh = room_mesh()
    if up == "y":
        mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, (1, 0, 0)))
    mesh.apply_scale(100)
    mesh.export(tmp_path / f"room.{suffix}")
    settings = {
        "kind": "mesh",
        "name": "mine",
        "mesh": f"room.{suffix}",
        "scale": 0.01,
        "up": up,
        "objects": [{"type": "carton", "at": [0, 0]}],
    }
    scene = load_scene(written(tmp_path, settings))
    (fixture,) = scene.fixtures
    vertices = np.concatenate([part.mesh.vertices for part in fixture.parts])
    assert vertices.max(0) == pytest.approx((2.05, 1.55, 2.4), abs=1e-3) and vertices[
        :, 2
    ].min() == pytest.approx(-0.1, abs=1e-3)
    squares = np.array([(*area.x, *area.y) for area in scene.areas])
    assert (squares[:, 0].min(), squares[:, 1].max()) == pytest.approx((-2.05, 2.05), abs=0.2)
    assert np.prod(squares[:, 1::2] - squares[:, ::2], axis=1).sum() == pytest.approx(
        4.1 * 3.1, rel=0.1
    )
    assert scene.movables[0].position == pytest.approx((0, 0, 0.151))
    (solid,) = fixture.solids
    assert solid.kind == "mesh" and (solid.vertices[solid.faces][..., 2].max(1) > 0.03).all()
    if suffix in ("ply", "glb"):
        assert {tuple(round(c, 1) for c in part.colour) for part in fixture.parts} == {
            (0.8, 0.1, 0.1),
            (0.1, 0.1, 0.8),
        }


def test_a_robot_starts_only_where_there_is_floor(tmp_path):
    """Rooms are seldom rectangles: of an L, the missing quarter is not started in."""
    parts = [
        trimesh.creation.box(
            (4, 2, 0.1), trimesh.transformations.translation_matrix((0, -1, -0.05))
        )
    ]
    parts.append(
        trimesh.creation.box(
            (2, 2, 0.1), trimesh.transformations.translation_matrix((-1, 1, -0.05))
        )
    )
    trimesh.util.concatenate(parts).export(tmp_path / "room.ply")
    scene = load_scene(
        written(tmp_path, {"kind": "mesh", "name": "mine", "mesh": "room.ply", "floor": 0.0})
    )
    middles = np.array([(np.mean(area.x), np.mean(area.y)) for area in scene.areas])
    assert len(middles) == 12 * 16 and not ((middles > 0).all(1)).any()


def test_a_mesh_without_a_floor_is_refused(tmp_path):
    walls = room_mesh(floor=False)
    level = np.abs(walls.face_normals[:, 2]) > 0.9
    walls.update_faces(~level)
    walls.export(tmp_path / "room.ply")
    with pytest.raises(SceneError, match="has no floor: no level surface"):
        load_scene(written(tmp_path, {"kind": "mesh", "name": "mine", "mesh": "room.ply"}))
    assert floor_height(np.asarray(walls.vertices), np.asarray(walls.faces)) is None
    given = load_scene(
        written(tmp_path, {"kind": "mesh", "name": "mine", "mesh": "room.ply", "floor": -1.3})
    )
    assert given.fixtures[0].parts[0].mesh.vertices[:, 2].max() == pytest.approx(2.4)


@pytest.mark.parametrize(
    ("content", "settings", "message"),
    [
        (None, {}, "mesh: there is no file 'room.ply'"),
        ("no mesh", {}, "cannot be read"),
        (
            "mesh",
            {"objects": [{"type": "mug", "stands_on": "table", "at": [0, 0]}]},
            "nothing can stand on it by name",
        ),
        ("mesh", {"scale": -1}, "scale"),
    ],
)
def test_a_mesh_scene_that_makes_no_sense_is_refused(tmp_path, content, settings, message):
    if content == "mesh":
        room_mesh().export(tmp_path / "room.ply")
    elif content is not None:
        (tmp_path / "room.ply").write_text(content)
    with pytest.raises(SceneError, match=message):
        load_scene(
            written(tmp_path, {"kind": "mesh", "name": "mine", "mesh": "room.ply", **settings})
        )
