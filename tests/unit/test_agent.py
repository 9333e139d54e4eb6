"""worlds/flatland/agent.py and from_config.py: Polyphemus and what the configuration changes about it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensory_commutativity.helpers import DOFS, changed, linkage

from sensory_commutativity.studies.flatland.builders import (
    flatland_agent,
    flatland_room,
    flatland_world,
)
from sensory_commutativity.worlds.flatland.agent import JOINT_NAMES, N_LINKS, PARENT, Polyphemus

NAMES = [
    "base-longitudinal",
    "base-rotation",
    "head",
    "eyelid",
    "left-shoulder",
    "left-elbow",
    "right-shoulder",
    "right-elbow",
]


def test_the_dofs_and_their_speeds():
    dofs = Polyphemus(longitudinal_speed=3.0, angular_speed=0.1, eyelid_speed=0.02).dofs
    assert [dof.name for dof in dofs] == NAMES == DOFS
    assert [dof.speed for dof in dofs] == [3.0, 0.1, 0.1, 0.02, 0.1, 0.1, 0.1, 0.1]
    assert [dof.unit for dof in dofs] == ["units", "rad", "rad", "1", "rad", "rad", "rad", "rad"]
    assert [dof.displaces for dof in dofs] == [True, True, False, False, True, True, True, True]


def test_limits():
    dofs = dict(zip(NAMES, Polyphemus(joint_range=1.0).dofs, strict=True))
    assert (dofs["left-elbow"].low, dofs["left-elbow"].high) == (-1.0, 1.0)
    assert (dofs["eyelid"].low, dofs["eyelid"].high) == (-1.0, 1.0)  # starts at 1, from 0 to 2
    assert (dofs["head"].low, dofs["base-rotation"].high) == (-math.inf, math.inf)
    assert Polyphemus().dofs[4].high == math.inf


def test_what_hangs_on_what():
    assert N_LINKS == len(PARENT) == 5
    assert PARENT == (-1, 0, 1, 0, 3)
    assert tuple(NAMES[4:]) == JOINT_NAMES


def test_poses_by_hand():
    """Looking along x at the origin, arms straight ahead."""
    agent = Polyphemus(base_radius=10.0, arm_length=4.0, shoulder_rest=0.0, elbow_rest=0.0)
    assert np.allclose(
        agent.link_poses(0, 0, 0), [[0, 0, 0], [2, 10, 0], [6, 10, 0], [2, -10, 0], [6, -10, 0]]
    )


@given(st.floats(-500, 500), st.floats(-500, 500), st.floats(-4, 4), st.floats(1, 150))
def test_poses_against_forward_kinematics(x, y, heading, arm_length):
    agent = Polyphemus(arm_length=arm_length)
    assert np.allclose(
        agent.link_poses(x, y, heading), linkage(agent, x, y, heading, agent.rest_angles), atol=1e-9
    )


def test_the_arms_are_mirror_images():
    agent = Polyphemus()
    poses = agent.link_poses(0, 0, 0)
    assert np.allclose(poses[1:3] * [1, -1, -1], poses[3:5])
    assert agent.rest_angles.tolist() == pytest.approx(np.radians([60, -30, -60, 30]).tolist())
    assert agent.joint_signs.tolist() == [1, 1, -1, -1]


# ---- from the configuration ------------------------------------------------------------------------------------------------


def test_an_empty_section_is_the_standard_agent(default_config):
    assert flatland_agent(default_config.flatland, "polyphemus") == Polyphemus()


def test_an_agent_is_as_the_configuration_says(default_config):
    config = changed(
        default_config,
        agents={
            "mine": {
                "arm_length": 30.0,
                "longitudinal_speed": 2.0,
                "angular_speed": 0.125,
                "joint_range_degrees": 90.0,
            }
        },
    )
    assert flatland_agent(config.flatland, "mine") == Polyphemus(
        arm_length=30.0, longitudinal_speed=2.0, angular_speed=0.125, joint_range=math.pi / 2
    )


def test_a_room_is_as_the_configuration_says(default_config):
    settings = {
        "things": 3,
        "walls": False,
        "width": 400.0,
        "height": 500.0,
        "start_margin": 60.0,
        "path_speed": 1.5,
    }
    room = flatland_room(changed(default_config, worlds={"mine": settings}).flatland, "mine")
    assert {name: getattr(room, name) for name in settings} == settings


def test_a_world_is_made_of_both(default_config):
    world = flatland_world(default_config.flatland, "things-4", "long-arms")
    assert world.room == flatland_room(default_config.flatland, "things-4")
    assert world.agent == flatland_agent(default_config.flatland, "long-arms")
    assert world.agent.arm_length == 80 and world.room.things == 4
