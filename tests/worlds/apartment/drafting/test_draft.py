"""A first description from the URDF alone, and what the trial of a description finds."""

from __future__ import annotations

import pytest
import yaml

from sensory_commutativity.worlds.apartment.drafting.draft import draft_robot
from sensory_commutativity.worlds.apartment.drafting.probing import probe_robot
from sensory_commutativity.worlds.apartment.drafting.wheels import find_drive
from sensory_commutativity.worlds.apartment.drafting.yaml_text import format_draft
from sensory_commutativity.worlds.apartment.files import locate
from sensory_commutativity.worlds.apartment.physics.starts import StartError
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from sensory_commutativity.worlds.apartment.robots.urdf import RobotError
from sensory_commutativity.worlds.apartment.robots.urdf_reader import read_urdf
from tests.worlds.apartment.examples import ARM_URDF, write_robot

HUSKY = "package://pybullet_data/husky/husky.urdf"
PANDA = "package://pybullet_data/franka_panda/panda.urdf"


def draft(tmp_path, urdf):
    """Draft the description of a URDF, write it, and load it."""
    out = tmp_path / "robot.yaml"
    path = locate(urdf, tmp_path) if "://" in urdf else tmp_path / "mine.urdf"
    if "://" not in urdf:
        path.write_text(urdf)
    found = draft_robot(path, out)
    out.write_text(format_draft(found, "a test"))
    assert yaml.safe_load(out.read_text()) == found.settings
    return load_robot(out), found


def test_the_drive_of_a_robot_on_wheels_is_found(tmp_path):
    robot, found = draft(tmp_path, HUSKY)
    assert found.settings["urdf"] == HUSKY
    drive = robot.description.drive
    assert (drive.right_wheel, drive.left_wheel) == ("rear_right_wheel", "rear_left_wheel")
    assert robot.axle[0] == 0.0  # in the middle of four wheels, not of the two
    assert robot.track == pytest.approx(0.571, abs=0.01)
    assert [dof.group for dof in robot.description.dofs] == ["wheel", "wheel"]
    assert find_drive(read_urdf(locate(PANDA, tmp_path))) is None
    for probe in probe_robot(robot, tries=1):
        assert probe.moved == pytest.approx(probe.asked, rel=0.02) and probe.commuted == 1.0


def test_the_joints_of_an_arm_start_away_from_their_stops(tmp_path):
    robot, found = draft(tmp_path, PANDA)
    groups = [dof.group for dof in robot.description.dofs]
    assert groups == ["shoulder"] * 3 + ["elbow"] * 3 + ["wrist", "hand"]
    assert robot.followers.keys() == {"panda_finger_joint2"}
    low, high = robot.limits.T
    margin = 0.15 * (high - low)
    assert (robot.start_ranges[:, 0] >= low + margin - 1e-9).all()
    assert (robot.start_ranges[:, 1] <= high - margin + 1e-9).all()
    assert found.settings["hierarchy"] == ["shoulder", "elbow", "wrist"]
    for probe in probe_robot(robot):
        assert not probe.problems, probe
        assert probe.moved == pytest.approx(probe.asked, rel=0.02)


def test_links_that_always_touch_pass_through_each_other(tmp_path):
    hand = """<link name="hand"><collision><geometry><box size=".5 .3 .3"/></geometry></collision>
      </link><joint name="bend" type="revolute"><parent link="rod"/><child link="hand"/>
      <origin xyz="0 0 -.4"/><axis xyz="0 0 1"/><limit lower="-2" upper="2"/></joint></robot>"""
    _, found = draft(tmp_path, ARM_URDF.replace("</robot>", hand))
    assert found.settings["passing"] == [["foot", "hand"]]
    assert found.comments["foot hand"] == "touch in 100%"
    without = {key: value for key, value in found.settings.items() if key != "passing"}
    (tmp_path / "without.yaml").write_text(yaml.safe_dump(without))
    with pytest.raises(StartError, match=r"'foot' and 'hand' in 100%.*key passing"):
        probe_robot(load_robot(tmp_path / "without.yaml"))


def test_a_robot_on_legs_hangs_above_the_floor_and_says_so(tmp_path):
    robot, found = draft(tmp_path, "package://pybullet_data/a1/a1.urdf")
    assert any("stands on legs" in note for note in found.notes)
    groups = [dof.group for dof in robot.description.dofs]
    assert groups == ["hip", "thigh", "calf"] * 4
    assert 0.35 < robot.height < 0.6


def test_a_urdf_without_joints_is_no_robot(tmp_path):
    with pytest.raises(RobotError, match="no joint of it can move"):
        draft(tmp_path, '<robot name="a"><link name="b"/></robot>')


def test_the_trial_says_what_a_joint_does_not_do(tmp_path):
    heavy = ARM_URDF.replace('<mass value="1"/>', '<mass value="1e5"/>')
    (weak,) = probe_robot(load_robot(write_robot(tmp_path, {"arm_force": 1.0}, heavy)))
    assert weak.moved < 0.1 * weak.asked and "hardly moves" in weak.problems[0]
    (stopped,) = probe_robot(load_robot(write_robot(tmp_path, {"start": {"turn": [2, 2]}})))
    assert stopped.at_stop == 1.0 and "starts at a stop" in stopped.problems[0]
    (good,) = probe_robot(load_robot(write_robot(tmp_path)), tries=2)
    assert not good.problems and good.commuted == 1.0 and good.n == 2
