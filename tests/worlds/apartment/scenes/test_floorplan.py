"""A floor plan becomes walls, doors, furniture and objects, or is refused in one line."""

from __future__ import annotations

import pytest

from sensory_commutativity.worlds.apartment.scenes.scene import SceneError
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene
from tests.worlds.apartment.scenes.examples import PLAN, write_scene

ROOM = {"x": [0, 4], "y": [0, 3]}
TABLE, BED = (
    {"type": "table", "name": "t", "at": [1, 1]},
    {"type": "bed", "name": "t", "at": [3, 1]},
)
INVALID = [
    ({"rooms": {}}, "there is no floor to stand on"),
    ({"rooms": {"one": ROOM, "two": {"x": [3, 7], "y": [0, 3]}}}, "'one' and 'two' overlap"),
    ({"rooms": {"one": {"x": [4, 0], "y": [0, 3]}}}, "rooms.one.x: from 4 to 0 is no room"),
    ({"rooms": {"one": {**ROOM, "floor": "lava"}}, "doors": []}, "there is no texture 'lava'"),
    ({"doors": [{"at": [2, 1.5]}]}, r"doors\[0\]: no wall between two rooms"),
    ({"doors": [{"at": [0, 1.5]}]}, r"doors\[0\]: no wall between two rooms"),
    ({"doors": [{"at": [4, 1.5], "height": 2.5}]}, "does not fit under the ceiling"),
    ({"furniture": [{"type": "throne", "at": [1, 1]}]}, "no type 'throne'; choose among table, "),
    ({"furniture": [{"type": "table", "at": [9, 1]}], "objects": []}, "is in no room"),
    ({"furniture": [TABLE, BED]}, "two are called 't'"),
    ({"objects": [{"type": "anvil", "at": [1, 1]}]}, "no type 'anvil'; choose among cereal-box"),
    (
        {"objects": [{"type": "mug", "stands_on": "shelf", "at": [0, 0]}]},
        "stands on 'shelf', which is no furniture",
    ),
    (
        {"objects": [{"type": "mug", "stands_on": "wardrobe-2", "at": [0, 0]}]},
        "nothing can stand on 'wardrobe-2'; choose among desk",
    ),
    ({"colour": "red"}, "colour"),
]
"""Changes to the plan, and the error that they cause."""


def test_a_plan_becomes_walls_a_door_furniture_and_objects(tmp_path):
    scene = load_scene(write_scene(tmp_path, PLAN))
    fixtures = {fixture.name: fixture for fixture in scene.fixtures}
    assert {"one floor", "two ceiling", "desk", "wardrobe-2"} <= set(fixtures)
    assert {"one east wall 1", "one east lintel 1", "one east wall 2"} <= set(fixtures)
    (wall,) = fixtures["two west wall 1"].solids
    assert wall.position == pytest.approx((4.03, 0.5, 1.25))
    assert wall.size == pytest.approx((0.03, 0.5, 1.25))
    (lintel,) = fixtures["two west lintel 1"].solids
    assert lintel.position == pytest.approx((4.03, 1.5, (2.05 + 2.5) / 2))
    areas = {area.name: area.x for area in scene.areas}
    assert areas == {"one": (0.06, 3.94), "two": (4.06, 6.94)}
    mug, ball = scene.movables
    assert mug.position == pytest.approx((1 - 0.3, 1 + 0.2, 0.74 + 0.0475 + 0.001))
    assert ball.position == pytest.approx((2, 2, 0.111))


def test_an_invalid_plan_is_refused_in_one_line(tmp_path):
    for change, message in INVALID:
        path = write_scene(tmp_path, {**PLAN, **change})
        with pytest.raises(SceneError, match=message) as error:
            load_scene(path)
        assert str(error.value).startswith(str(path)), change
        assert "\n" not in str(error.value), change
