"""Worlds by name."""

from __future__ import annotations

import pytest

from sensory_commutativity import ArgumentError, UserError, World, make_apartment, make_world
from sensory_commutativity.worlds.catalog import WORLDS, list_robots, list_scenes


def test_every_world_is_a_world() -> None:
    for name in WORLDS:
        assert isinstance(make_world(name), World)
    assert make_world("flatland", objects=3).room.objects == 3


def test_robots_and_scenes_by_name_and_by_file() -> None:
    world = make_apartment("jackrabbot", "free-space", image_size=32)
    assert world.name.endswith("in free-space") and world.cameras[0].width == 32
    assert {"fetch", "jackrabbot"} <= set(list_robots())
    assert {"rs-stand-in", "free-space"} <= set(list_scenes())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(name="flatlnd"), "there is no world 'flatlnd'; did you mean 'flatland'"),
        (dict(name="corridor", boxes=1), "no option 'boxes'; it has wall, box"),
        (dict(name="flatland", object=1), "no option 'object'; it has width, height"),
        (dict(name="apartment", robot="fetsh"), "robot: there is no robot 'fetsh'"),
        (dict(name="apartment", scene="rs"), "scene: there is no scene 'rs'; .* free-space"),
    ],
)
def test_unknown_names_are_answered_with_the_known_ones(arguments, message) -> None:
    with pytest.raises(ArgumentError, match=message):
        make_world(**arguments)


def test_a_missing_file_is_named() -> None:
    with pytest.raises(UserError, match=r"nowhere\.yaml"):
        make_apartment(robot="nowhere.yaml")
