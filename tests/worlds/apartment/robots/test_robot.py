"""Robots from their descriptions: the shipped ones, a user's own, and invalid ones."""

from __future__ import annotations

import re

import numpy as np
import pytest

from sensory_commutativity.worlds.apartment import frames as fr
from sensory_commutativity.worlds.apartment.robots.body import build_body
from sensory_commutativity.worlds.apartment.robots.bullet_urdf import merge_inertials
from sensory_commutativity.worlds.apartment.robots.loading import load_robot, set_fixed_joints
from sensory_commutativity.worlds.apartment.robots.urdf import Link, RobotError
from tests.worlds.apartment.examples import ARM, ARM_URDF, ROBOTS, write_robot


def test_shipped_robots_load():
    for name, n_dofs in (("fetch", 10), ("jackrabbot", 7)):
        robot = load_robot(ROBOTS / f"{name}.yaml")
        assert len(robot.dofs) == n_dofs, name
        assert list(robot.hierarchy) == ["wheel", "shoulder", "elbow", "wrist"], name
        assert robot.hierarchy["wheel"] == ["right-wheel", "left-wheel"], name
        assert robot.description.drive is not None, name
        assert (robot.start_ranges >= robot.limits[:, :1]).all(), name
        assert (robot.start_ranges <= robot.limits[:, 1:]).all(), name
        body = build_body(robot)
        assert len(body.parts) >= 8, name
        assert sum(len(part.mesh.faces) for _, part in body.parts) < 5_000, name


def test_fetch_has_the_dimensions_of_its_datasheet():
    """Fetch is 1.1 m high with the torso down, and its arm 0.94 m long without the hand."""
    robot = load_robot(ROBOTS / "fetch.yaml")
    body = build_body(robot)
    poses = body.link_poses(np.zeros(3), np.zeros(len(robot.joints)))
    vertices = [fr.apply(poses[link], part.mesh.vertices) for link, part in body.parts]
    heights = np.concatenate(vertices)[:, 2]
    assert heights.max() == pytest.approx(1.1, abs=0.05)
    assert heights.min() == pytest.approx(0.0, abs=0.02)
    link, frame = body.source_links["wrist_roll_link"]
    shoulder = [joint.name for joint in robot.joints].index("shoulder_pan_joint") + 1
    reach = np.linalg.norm((poses[link] @ frame)[:3, 3] - poses[shoulder][:3, 3])
    assert reach == pytest.approx(0.94, abs=0.02)


def test_a_users_own_robot(tmp_path):
    robot = load_robot(write_robot(tmp_path))
    (dof,) = robot.dofs
    assert (dof.name, dof.unit, dof.low, dof.high) == ("turn", "rad", -2.0, 2.0)
    assert dof.speed == pytest.approx(0.1) and robot.hierarchy == {}
    poses = build_body(robot).link_poses(np.array([1.0, 2.0, 0.0]), np.array([np.pi / 2]))
    (tip,) = fr.apply(poses[1], np.array([[0.5, 0.0, 0.0]]))
    assert tip == pytest.approx((1.0, 2.5, 0.5))


def test_merged_links_have_the_inertia_of_the_whole_and_of_a_possible_body():
    ball = Link("ball", 2.0, np.zeros(3), np.eye(3) * 0.1, (), ())
    pair = [(ball, fr.from_rpy((x, 0.0, 0.0))) for x in (-0.5, 0.5)]
    mass, frame, moments = merge_inertials(pair)
    assert mass == 4.0 and np.allclose(frame[:3, 3], 0)
    assert moments == pytest.approx([0.2, 1.2, 1.2])  # parallel axes: 2 (0.1 + 2 kg (0.5 m)^2)
    assert np.linalg.det(frame[:3, :3]) == pytest.approx(1.0)
    impossible = Link("rod", 1.0, np.zeros(3), np.diag([0.1, 0.1, 5.0]), (), ())
    moments = merge_inertials([(impossible, np.eye(4))]).moments
    assert moments[2] <= moments[0] + moments[1]
    assert merge_inertials([]).mass > 0 and (merge_inertials([]).moments > 0).all()


def test_invalid_robots_are_rejected_in_one_line(tmp_path):
    (dof,) = ARM["dofs"]
    cases = [
        ({"urdf": "none.urdf"}, ARM_URDF, "urdf: there is no file 'none.urdf'"),
        ({}, "<robot", "not valid XML in line 1"),
        ({}, "<sdf/>", "the outermost element is <sdf>"),
        (
            {},
            ARM_URDF.replace('child link="eye"', 'child link="nose"'),
            "joint 'mount' names the link 'nose', which does not exist",
        ),
        (
            {},
            ARM_URDF.replace("<box", '<mesh filename="x.stl"/><box', 1),
            "names the mesh 'x.stl', which does not exist",
        ),
        (
            {"dofs": [{**dof, "joints": ["bend"]}]},
            ARM_URDF,
            "'turn' names the joint 'bend', which mine.urdf does not contain; choose one of turn",
        ),
        (
            {"dofs": [{**dof, "joints": ["mount"]}]},
            ARM_URDF,
            "names the joint 'mount', which cannot move; choose one of turn",
        ),
        (
            {"dofs": [{**dof, "unit": "m"}]},
            ARM_URDF,
            "has the unit m, but its joint 'turn' is revolute; write rad",
        ),
        (
            {"camera": {"link": "nose", "position": [0, 0, 0]}},
            ARM_URDF,
            "camera.link: mine.urdf has no link 'nose'",
        ),
        (
            {"start": {"turn": [-3, 0]}},
            ARM_URDF,
            "would start from -3 to 0, beyond its limits -2 to 2",
        ),
        (
            {"hierarchy": ["arm", "leg"]},
            ARM_URDF,
            "no degree of freedom is in the group 'leg'; the groups are arm",
        ),
        ({"hierarchy": ["arm", "arm"]}, ARM_URDF, "the group 'arm' is listed twice"),
        ({"velocity": 3}, ARM_URDF, "velocity"),
    ]
    for description, urdf, message in cases:
        with pytest.raises(RobotError, match=re.escape(message)) as error:
            load_robot(write_robot(tmp_path, description, urdf))
        assert "\n" not in str(error.value) and str(tmp_path) in str(error.value), message
    with pytest.raises(RobotError, match="there is no such file"):
        load_robot(tmp_path / "none.yaml")


def test_fixed_joints_can_be_set_within_their_limits():
    robot = load_robot(ROBOTS / "fetch.yaml")
    up = set_fixed_joints(robot, {"head_tilt_joint": -0.3}, "masks")
    assert up.description.fixed == robot.description.fixed | {"head_tilt_joint": -0.3}
    for fixed, message in (
        ({"head_tilt_joint": 9.0}, "masks: fixed: 'head_tilt_joint' cannot be at 9"),
        ({"elbow_flex_joint": 0.0}, "is moved by 'elbow-flex'"),
        ({"tail": 0.0}, "has no movable joint 'tail'"),
    ):
        with pytest.raises(RobotError, match=message):
            set_fixed_joints(robot, fixed, "masks")
