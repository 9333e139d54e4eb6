"""worlds/flatland/agent.py: the degrees of freedom and the geometry of Polyphemus."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensory_commutativity.worlds.flatland.agent import JOINT_NAMES, Polyphemus
from tests.helpers import forward_kinematics


def test_degrees_of_freedom():
    agent = Polyphemus(
        longitudinal_speed=3.0, angular_speed=0.1, eyelid_speed=0.02, joint_range=1.0
    )
    inf = math.inf
    assert [(d.name, d.unit, d.speed, d.low, d.high, d.displaces) for d in agent.dofs] == [
        ("base-longitudinal", "units", 3.0, -inf, inf, True),
        ("base-rotation", "rad", 0.1, -inf, inf, True),
        ("head", "rad", 0.1, -inf, inf, False),
        ("eyelid", "1", 0.02, -1.0, 1.0, False),  # starts at 1, range 0 to 2
        ("left-shoulder", "rad", 0.1, -1.0, 1.0, True),
        ("left-elbow", "rad", 0.1, -1.0, 1.0, True),
        ("right-shoulder", "rad", 0.1, -1.0, 1.0, True),
        ("right-elbow", "rad", 0.1, -1.0, 1.0, True),
    ]
    assert tuple(dof.name for dof in agent.dofs[4:]) == JOINT_NAMES
    assert Polyphemus().dofs[4].high == inf


def test_link_poses_by_hand():
    """At the origin, looking along the x axis, arms straight ahead."""
    agent = Polyphemus(base_radius=10.0, arm_length=4.0, shoulder_rest=0.0, elbow_rest=0.0)
    expected = [[0, 0, 0], [2, 10, 0], [6, 10, 0], [2, -10, 0], [6, -10, 0]]
    assert np.allclose(agent.link_poses(0, 0, 0), expected)


@given(st.floats(-500, 500), st.floats(-500, 500), st.floats(-4, 4), st.floats(1, 150))
def test_link_poses_against_forward_kinematics(x, y, heading, arm_length):
    agent = Polyphemus(arm_length=arm_length)
    expected = forward_kinematics(agent, x, y, heading, agent.rest_angles)
    assert np.allclose(agent.link_poses(x, y, heading), expected, atol=1e-9)


def test_arms_are_mirror_images():
    agent = Polyphemus()
    poses = agent.link_poses(0, 0, 0)
    assert np.allclose(poses[1:3] * [1, -1, -1], poses[3:5])
    assert agent.rest_angles.tolist() == pytest.approx(np.radians([60, -30, -60, 30]).tolist())
    assert agent.joint_signs.tolist() == [1, 1, -1, -1]
