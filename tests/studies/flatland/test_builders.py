"""studies/flatland/builders.py: agents, rooms and worlds from the configuration."""

from __future__ import annotations

import math

import pytest

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.studies.flatland.builders import (
    check_rooms,
    flatland_agent,
    flatland_room,
    flatland_world,
)
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from tests.helpers import update_flatland


def test_agents_follow_the_configuration(default_config):
    assert flatland_agent(default_config.flatland, "polyphemus") == Polyphemus()
    settings = {"arm_length": 30.0, "longitudinal_speed": 2.0, "angular_speed": 0.125}
    config = update_flatland(
        default_config, agents={"mine": {**settings, "joint_range_degrees": 90.0}}
    )
    expected = Polyphemus(**settings, joint_range=math.pi / 2)
    assert flatland_agent(config.flatland, "mine") == expected


def test_rooms_follow_the_configuration(default_config):
    settings = {
        "objects": 3,
        "walls": False,
        "width": 400.0,
        "height": 500.0,
        "start_margin": 60.0,
        "path_speed": 1.5,
    }
    config = update_flatland(default_config, worlds={"mine": settings})
    room = flatland_room(config.flatland, "mine")
    assert {name: getattr(room, name) for name in settings} == settings


def test_worlds_combine_room_and_agent(default_config):
    world = flatland_world(default_config.flatland, "things-4", "long-arms")
    assert world.room == flatland_room(default_config.flatland, "things-4")
    assert world.agent == flatland_agent(default_config.flatland, "long-arms")
    assert world.agent.arm_length == 80 and world.room.objects == 4


def test_check_rooms_names_what_does_not_fit(default_config):
    check_rooms(default_config)
    crowded = {"things-8": {"objects": 24, "width": 320.0, "height": 320.0}}
    message = r"flatland\.worlds\.things-8 with flatland\.agents\..*no free place"
    with pytest.raises(ConfigError, match=message):
        check_rooms(update_flatland(default_config, worlds=crowded))
    narrow = update_flatland(
        default_config,
        worlds={"things-0": {"width": 305.0, "height": 305.0}},
        agents={"long-arms": {"arm_length": 150.0}},
    )
    message = r"things-0 with flatland\.agents\.long-arms: the agent does not fit"
    with pytest.raises(ConfigError, match=message):
        check_rooms(narrow)
