"""Robots from their descriptions: the two that come with the project, a user's own, and what is refused, in one clear line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from sensory_commutativity.worlds.apartment import frames as fr
from sensory_commutativity.worlds.apartment.robots.body import build_body
from sensory_commutativity.worlds.apartment.robots.robot import load_robot
from sensory_commutativity.worlds.apartment.robots.urdf import RobotError

ROBOTS = Path(__file__).parents[2] / "config" / "robots"
URDF = """<robot name="arm">
  <link name="foot"><inertial><mass value="3"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size=".3 .3 .2"/></geometry></collision></link>
  <link name="rod"><inertial><origin xyz=".25 0 0"/><mass value="1"/><inertia ixx=".01" iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz=".25 0 0"/><geometry><box size=".5 .05 .05"/></geometry><material name="m"><color rgba="1 0 0 1"/></material></visual>
    <collision><origin xyz=".25 0 0"/><geometry><box size=".5 .05 .05"/></geometry></collision></link>
  <link name="eye"/>
  <joint name="turn" type="revolute"><parent link="foot"/><child link="rod"/><origin xyz="0 0 .5"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2"/></joint>
  <joint name="mount" type="fixed"><parent link="rod"/><child link="eye"/><origin xyz=".1 0 .2"/></joint>
</robot>"""
OWN = {
    "name": "mine",
    "urdf": "mine.urdf",
    "dofs": [{"name": "turn", "joints": ["turn"], "unit": "rad", "velocity": 1.0, "group": "arm"}],
    "camera": {"link": "eye", "position": [0, 0, 0]},
}


def written(tmp_path: Path, description=None, urdf: str = URDF) -> Path:
    (tmp_path / "mine.urdf").write_text(urdf)
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump({**OWN, **(description or {})}))
    return tmp_path / "mine.yaml"


@pytest.mark.parametrize(("name", "dofs"), [("fetch", 10), ("jackrabbot", 7)])
def test_a_shipped_robot_loads(name, dofs):
    robot = load_robot(ROBOTS / f"{name}.yaml")
    assert len(robot.dofs) == dofs and list(robot.hierarchy) == [
        "wheel",
        "shoulder",
        "elbow",
        "wrist",
    ]
    assert (
        robot.hierarchy["wheel"] == ["right-wheel", "left-wheel"]
        and robot.description.drive is not None
    )
    assert (robot.start_ranges >= robot.limits[:, :1]).all() and (
        robot.start_ranges <= robot.limits[:, 1:]
    ).all()
    body = build_body(robot)
    assert len(body.parts) >= 8 and sum(len(part.mesh.faces) for _, part in body.parts) < 5_000


def test_fetch_has_the_sizes_of_fetch():
    """Datasheet of the Fetch mobile manipulator: 1.1 m high with the torso down, the arm without the hand 0.94 m long."""
    robot = load_robot(ROBOTS / "fetch.yaml")
    body = build_body(robot)
    poses = body.link_poses(np.zeros(3), np.zeros(len(robot.joints)))
    seen = np.concatenate([fr.apply(poses[link], part.mesh.vertices) for link, part in body.parts])
    assert seen[:, 2].max() == pytest.approx(1.1, abs=0.05) and seen[:, 2].min() == pytest.approx(
        0.0, abs=0.02
    )
    link, frame = body.where["wrist_roll_link"]
    reach = np.linalg.norm(
        (poses[link] @ frame)[:3, 3]
        - poses[[j.name for j in robot.joints].index("shoulder_pan_joint") + 1][:3, 3]
    )
    assert reach == pytest.approx(0.94, abs=0.02)


def test_a_users_own_robot_by_config_alone(tmp_path):
    robot = load_robot(written(tmp_path, {"start": {"turn": [-0.5, 0.5]}}))
    (dof,) = robot.dofs
    assert (dof.name, dof.unit, dof.speed, dof.low, dof.high) == (
        "turn",
        "rad",
        pytest.approx(0.1),
        -2.0,
        2.0,
    )
    body = build_body(robot)
    tip = fr.apply(
        body.link_poses(np.array([1.0, 2.0, 0.0]), np.array([np.pi / 2]))[1],
        np.array([[0.5, 0, 0]]),
    )[0]
    assert tip == pytest.approx((1.0, 2.5, 0.5)) and robot.hierarchy == {}


@pytest.mark.parametrize(
    ("description", "urdf", "message"),
    [
        ({"urdf": "none.urdf"}, URDF, "urdf: there is no file 'none.urdf'"),
        ({}, "<robot", "not valid XML in line 1"),
        ({}, "<sdf/>", "the outermost element is <sdf>"),
        (
            {},
            URDF.replace('child link="eye"', 'child link="nose"'),
            "holds the link 'nose', which is not there",
        ),
        (
            {},
            URDF.replace("<box", '<mesh filename="x.stl"/><box', 1),
            "names the mesh 'x.stl', which is not there",
        ),
        (
            {"dofs": [{**OWN["dofs"][0], "joints": ["bend"]}]},
            URDF,
            "dofs: 'turn' names the joint 'bend', which mine.urdf has not; it has turn",
        ),
        (
            {"dofs": [{**OWN["dofs"][0], "joints": ["mount"]}]},
            URDF,
            "which cannot move; choose one of turn",
        ),
        (
            {"dofs": [{**OWN["dofs"][0], "unit": "m"}]},
            URDF,
            "has the unit m, but its joint 'turn' is revolute; write rad",
        ),
        (
            {"camera": {"link": "nose", "position": [0, 0, 0]}},
            URDF,
            "camera.link: mine.urdf has no link 'nose'",
        ),
        ({"start": {"turn": [-3, 0]}}, URDF, "would start from -3 to 0, beyond its limits"),
        (
            {"hierarchy": ["arm", "leg"]},
            URDF,
            "hierarchy: no degree of freedom is of the group 'leg'; the groups are arm",
        ),
        ({"hierarchy": ["arm", "arm"]}, URDF, "hierarchy: the group 'arm' is there twice"),
        ({"velocity": 3}, URDF, "velocity"),
    ],
)
def test_a_robot_that_makes_no_sense_is_refused_in_one_line(tmp_path, description, urdf, message):
    with pytest.raises(RobotError, match=message) as error:
        load_robot(written(tmp_path, description, urdf))
    assert "\n" not in str(error.value) and str(tmp_path) in str(error.value)


def test_a_description_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(RobotError, match="there is no such file"):
        load_robot(tmp_path / "none.yaml")
