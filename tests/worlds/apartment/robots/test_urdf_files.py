"""URDFs as the world writes them are read, or refused in one line that names cause and remedy."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

from sensory_commutativity.worlds.apartment.robots.body import build_body
from sensory_commutativity.worlds.apartment.robots.bullet_urdf import merge_inertials
from sensory_commutativity.worlds.apartment.robots.checks import check_shapes
from sensory_commutativity.worlds.apartment.robots.control import make_controller
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from sensory_commutativity.worlds.apartment.robots.urdf import Link, RobotError
from sensory_commutativity.worlds.apartment.robots.urdf_reader import read_urdf
from tests.worlds.apartment.examples import ARM_URDF, write_robot

BODY = ARM_URDF.partition(">")[2]
"""The arm without its first tag."""

CAR_URDF = """<robot name="car"><link name="base">
  <collision><geometry><box size=".3 .3 .2"/></geometry></collision></link>
  <link name="r"><collision><origin rpy="1.5708 0 0"/>
    <geometry><cylinder radius=".1" length=".04"/></geometry></collision></link>
  <link name="l"><collision><origin rpy="1.5708 0 0"/>
    <geometry><cylinder radius=".1" length=".04"/></geometry></collision></link>
  <joint name="jr" type="continuous"><parent link="base"/><child link="r"/>
    <origin xyz="RIGHT"/><axis xyz="0 1 0"/></joint>
  <joint name="jl" type="continuous"><parent link="base"/><child link="l"/>
    <origin xyz="LEFT"/><axis xyz="0 1 0"/></joint>
</robot>"""
WHEELS = [
    {"name": name, "joints": [f"j{name}"], "unit": "rad", "velocity": 5.0, "group": "wheel"}
    for name in ("r", "l")
]
CAR = {
    "urdf": "mine.urdf",
    "dofs": WHEELS,
    "start": {},
    "camera": {"link": "base", "position": [0, 0, 0.5]},
    "drive": {"right_wheel": "jr", "left_wheel": "jl"},
}

GRIPPER_URDF = ARM_URDF.replace(
    "</robot>",
    """<link name="f1"/><link name="f2"/>
  <joint name="grip" type="prismatic"><parent link="rod"/><child link="f1"/><axis xyz="0 1 0"/>
    <limit lower="0" upper=".04"/></joint>
  <joint name="grip2" type="prismatic"><parent link="rod"/><child link="f2"/><axis xyz="0 1 0"/>
    <limit lower="-.1" upper=".1"/><mimic joint="grip" multiplier="-2" offset=".01"/></joint>
</robot>""",
)


def write_urdf(folder: Path, text: str | bytes) -> Path:
    path = folder / "mine.urdf"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def with_mesh(name: str) -> str:
    return ARM_URDF.replace('<box size=".5 .05 .05"/>', f'<mesh filename="{name}"/>')


def car(right: str = "0 -.2 0", left: str = "0 .2 0") -> str:
    return CAR_URDF.replace("RIGHT", right).replace("LEFT", left)


def test_xml_is_read_as_pybullet_and_ros_read_it(tmp_path):
    declared = '<?xml version="1.0" encoding="{}"?>'
    for case, text in {
        "blank line first": '\n\n<?xml version="1.0"?>\n' + ARM_URDF,
        "comment first": "<!-- made -- by hand -->" + declared.format("utf-8") + ARM_URDF,
        "bytes after the end": ARM_URDF + "\n\x00\x00 written by a tool",
        "two robots, the second cut off": ARM_URDF + "<robot",
        "byte order mark": b"\xef\xbb\xbf" + ARM_URDF.encode(),
        "UTF-16": ARM_URDF.encode("utf-16"),
        "UTF-16, declared as UTF-8": (declared.format("utf-8") + ARM_URDF).encode("utf-16"),
        "UTF-8, declared as UTF-16": declared.format("utf-16") + ARM_URDF,
        "Latin-1, not declared": ("<!-- caf\xe9 -->" + ARM_URDF).encode("latin-1"),
        "unknown encoding": declared.format("nonsense") + ARM_URDF,
        "default namespace": '<robot name="arm" xmlns="http://www.ros.org">' + BODY,
        "prefixed namespace": '<r:robot name="arm" xmlns:r="http://www.ros.org">'
        + BODY.replace("</robot>", "</r:robot>"),
        "undeclared prefix": ARM_URDF.replace("</robot>", "<sensor:camera/></robot>"),
        "undeclared prefix of an attribute": ARM_URDF.replace("<robot", "<robot a:b='1'"),
        "bare ampersand": ARM_URDF.replace('name="m"', 'name="black & white"'),
        "numbers with commas": ARM_URDF.replace('xyz="0 0 .5"', 'xyz="0, 0, .5"'),
        "optional variable": ARM_URDF.replace('xyz="0 0 .5"', 'xyz="$(optenv NOBODY 0 0 .5)"'),
    }.items():  # fmt: skip
        urdf = read_urdf(write_urdf(tmp_path, text))
        assert list(urdf.links) == ["foot", "rod", "eye"], case
        assert urdf.joints["turn"].frame[2, 3] == 0.5, case


def test_what_is_no_urdf_is_told_with_cause_and_remedy(tmp_path):
    bomb = '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>'
    many = "".join(f'<link name="l{i}"/>' for i in range(3000))
    for case, (text, message) in {
        "reason": ("<robot><link></robot>", "not valid XML in line 1 (mismatched tag)"),
        "entities": (bomb + ARM_URDF, "declares entities"),
        "deep": ("<robot>" + "<a>" * 200 + "</a>" * 200 + "</robot>", "more than 100 levels deep"),
        "many links": (f"<robot>{many}</robot>", "3,000 links, more than 2,000"),
        "empty": ("", "is empty"),
        "no links": ("<robot/>", "contains no links"),
        "loop": (
            '<robot><link name="a"/><joint name="j" type="fixed"><parent link="a"/>'
            '<child link="a"/></joint></robot>',
            "the joints form a loop",
        ),
        "mjcf": ("<mujoco/>", "MuJoCo (MJCF); measure it as an environment"),
        "sdf": ("<sdf/>", "Gazebo (SDF); convert it"),
        "planar": (
            ARM_URDF.replace('type="fixed"', 'type="planar"'),
            "is of type 'planar'; replace it by two prismatic joints",
        ),
        "floating": (
            ARM_URDF.replace('type="fixed"', 'type="floating"'),
            "'rod' is not the root; only the root may float",
        ),
        "xacro expression": (ARM_URDF.replace(".5 .05", "${w} .05"), "an expression of xacro"),
        "millimetres": (ARM_URDF.replace(".5 .05 .05", "500 50 50"), "are these millimetres?"),
        "far joint": (ARM_URDF.replace("0 0 .5", "0 0 500"), "500 m from its parent"),
        "negative": (ARM_URDF.replace(".3 .3 .2", ".3 .3 -.2"), "negative size"),
        "mimics itself": (
            ARM_URDF.replace("<limit", '<mimic joint="turn"/><limit'),
            "joint 'turn' mimics itself",
        ),
        "pointer": (
            "version https://git-lfs.github.com/spec/v1\noid sha256:0", "is a Git LFS pointer",
        ),
        "web page": ("<!DOCTYPE html><html></html>", "is a web page"),
    }.items():  # fmt: skip
        with pytest.raises(RobotError) as error:
            read_urdf(write_urdf(tmp_path, text))
        assert message in str(error.value) and "\n" not in str(error.value), (case, error.value)


def test_a_file_that_is_no_xml_is_refused_in_linear_time(tmp_path):
    size = 2_000_000
    for case, text in {
        "blanks in the declaration": "<?xml" + " " * size,
        "open comments": "<robot>" + "<!--" * (size // 4),
        "open instructions": "<robot>" + "<?a" * (size // 3),
        "prefixes": "<robot>" + " a:" * (size // 3),
        "ampersands": "<robot>" + "&#1" * (size // 3),
    }.items():
        start = time.process_time()
        with pytest.raises(RobotError):
            read_urdf(write_urdf(tmp_path, text))
        assert time.process_time() - start < 5, case


def test_only_regular_files_are_opened(tmp_path):
    os.mkfifo(tmp_path / "mine.urdf")
    with pytest.raises(RobotError, match="not a regular file"):
        read_urdf(tmp_path / "mine.urdf")


def test_a_floating_root_stands_where_it_is_placed(tmp_path):
    text = ARM_URDF.replace(
        '<robot name="arm">',
        """<robot name="arm"><link name="world"/>
      <joint name="free" type="floating"><parent link="world"/><child link="foot"/></joint>""",
    )
    urdf = read_urdf(write_urdf(tmp_path, text))
    assert urdf.joints["free"].kind == "fixed" and "does not fall" in urdf.notes[0]


def test_a_capsule_has_round_caps(tmp_path):
    text = ARM_URDF.replace('<box size=".5 .05 .05"/>', '<capsule radius=".1" length=".4"/>')
    robot = load_robot(write_robot(tmp_path, urdf=text))
    ((_, part),) = build_body(robot).parts[-1:]
    assert np.ptp(part.mesh.vertices[:, 2]) == pytest.approx(0.6)
    assert '<capsule radius="0.1" length="0.4"' in build_body(robot).urdf.read_text()


# ---- meshes ----------------------------------------------------------------------------------


def test_meshes_are_found_where_ros_and_gazebo_find_them(tmp_path, monkeypatch):
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    package = tmp_path / "ws" / "src" / "a-fork" / "meshes"
    package.mkdir(parents=True)
    box.export(package / "wheel.stl")
    (package.parent / "package.xml").write_text("<package><name>thing</name></package>")
    models = tmp_path / "models"
    (models / "lamp").mkdir(parents=True)
    box.export(models / "lamp" / "part.stl")
    own = tmp_path / "own" / "urdf"
    own.mkdir(parents=True)
    (own.parent / "meshes").mkdir()
    box.export(own.parent / "meshes" / "part.stl")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(models))
    with pytest.raises(RobotError, match="set ROS_PACKAGE_PATH"):
        read_urdf(write_urdf(own, with_mesh("package://thing/meshes/wheel.stl")))
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{tmp_path / 'ws'}")
    for name in (
        "package://thing/meshes/wheel.stl",
        "package://thing//meshes/wheel.stl",
        "package://own_description/meshes/part.stl",  # a folder that was renamed
        "model://lamp/part.stl",
        "../meshes/part.stl",
        "meshes/part.stl",
        "..\\meshes\\part.stl",
        f"file://{models}/lamp/part.stl",
    ):
        urdf = read_urdf(write_urdf(own, with_mesh(name)))
        assert urdf.links["rod"].visuals[0].path.is_file(), name


def test_meshes_that_are_missing_are_told_with_what_is_there(tmp_path):
    (tmp_path / "meshes").mkdir()
    trimesh.creation.box((0.1, 0.1, 0.1)).export(tmp_path / "meshes" / "part.stl")
    for name, message in (
        ("Meshes/Part.STL", "but meshes/part.stl does"),
        ("meshes/prt.stl", "but meshes/part.stl does"),
        ("meshes/gone.stl", "looked for"),
        ("https://example.org/part.stl", "not fetched from the web"),
        ("model://thing/part.stl", "set GAZEBO_MODEL_PATH"),
        ("$(find thing)/part.stl", "an expression of xacro"),
        ("part.step", "does not exist"),
        ("meshes", "is not a regular file"),
    ):
        with pytest.raises(RobotError) as error:
            read_urdf(write_urdf(tmp_path, with_mesh(name)))
        assert message in str(error.value) and f"names the mesh {name!r}" in str(error.value)


def test_meshes_are_opened_before_anything_is_simulated(tmp_path):
    large = trimesh.creation.box((300, 30, 30)).export(file_type="stl")
    for content, message in (
        (b"", "is empty"),
        (b"version https://git-lfs.github.com/spec/v1", "is a Git LFS pointer"),
        (b"no mesh", "the mesh holds no triangles"),
        (large, 'write scale="0.001 0.001 0.001"'),
    ):
        (tmp_path / "part.stl").write_bytes(content)
        robot = load_robot(write_robot(tmp_path, urdf=with_mesh("part.stl")))
        for check in (check_shapes, build_body):
            with pytest.raises(RobotError, match=message):
                check(robot)


def test_collada_has_the_unit_that_it_names(tmp_path):
    pytest.importorskip("collada")
    content = trimesh.creation.box((10, 10, 30)).export(file_type="dae")
    content = content.replace(b"</asset>", b'<unit name="centimeter" meter="0.01"/></asset>', 1)
    (tmp_path / "part.dae").write_bytes(content)
    robot = load_robot(write_robot(tmp_path, urdf=with_mesh("part.dae")))
    check_shapes(robot)
    ((_, part),) = build_body(robot).parts[-1:]
    assert np.ptp(part.mesh.vertices, axis=0) == pytest.approx((0.1, 0.1, 0.3))


def test_a_mesh_whose_faces_look_inwards_is_seen(tmp_path):
    for inwards in (False, True):
        box = trimesh.creation.box((0.1, 0.1, 0.3))
        box.faces = box.faces[:, ::-1] if inwards else box.faces
        box.export(tmp_path / "part.stl")
        robot = load_robot(write_robot(tmp_path, urdf=with_mesh("part.stl")))
        assert build_body(robot).parts[-1][1].two_sided == inwards


def test_a_mesh_has_its_own_colour_where_the_urdf_gives_none(tmp_path):
    (tmp_path / "part.mtl").write_text("newmtl a\nKd 0 0 1\n")
    box = trimesh.creation.box((0.1, 0.1, 0.3)).export(file_type="obj")
    (tmp_path / "part.obj").write_text("mtllib part.mtl\nusemtl a\n" + box)
    text = with_mesh("part.obj")
    plain = text[: text.index("<material")] + text[text.index("</material>") + 11 :]
    for urdf, colour in ((text, (1, 0, 0)), (plain, (0, 0, 1))):
        robot = load_robot(write_robot(tmp_path, urdf=urdf))
        assert build_body(robot).parts[-1][1].colour == pytest.approx(colour, abs=0.01)


# ---- drive, mimic, inertia -------------------------------------------------------------------


def test_a_robot_turns_about_its_axle_wherever_the_root_is(tmp_path):
    robot = load_robot(write_robot(tmp_path, CAR, car("-.4 -.2 0", "-.4 .2 0")))
    assert robot.axle == pytest.approx((-0.4, 0.0, 0.0))
    assert (robot.track, robot.wheel_radius, robot.height) == pytest.approx((0.4, 0.1, 0.1))
    body = build_body(robot)
    for heading in (0.0, 2.0):
        root = body.link_poses(np.array([1.0, 2.0, heading]), np.zeros(0))[0]
        assert (root @ (-0.4, 0, 0, 1))[:2] == pytest.approx((1.0, 2.0))  # the axle stays
    sideways = load_robot(write_robot(tmp_path, CAR, car(".2 0 0", "-.2 0 0")))
    root = build_body(sideways).link_poses(np.zeros(3), np.zeros(0))[0]
    assert root[:3, 1] == pytest.approx((1, 0, 0))  # its y axis looks ahead


def test_a_drive_that_contradicts_the_urdf_is_refused(tmp_path):
    for drive, urdf, message in (
        (
            {"track": 400},
            car(),
            "is 400 m, but in mine.urdf the wheels are 0.4 m apart",
        ),
        ({"track": 0.8}, car(), "drive.track"),
        ({}, car("0 .2 0", "0 -.2 0"), "exchange them"),
        ({}, car("0 .2 0", "0 .2 0"), "both wheels at the same place"),
    ):
        settings = {**CAR, "drive": {**CAR["drive"], **drive}}
        with pytest.raises(RobotError) as error:
            load_robot(write_robot(tmp_path, settings, urdf))
        assert message in str(error.value)
    settings = {**CAR, "drive": {**CAR["drive"], "wheel_radius": 100}}
    with pytest.raises(RobotError, match=r"has a wheel of 0\.1 m"):
        check_shapes(load_robot(write_robot(tmp_path, settings, car())))


def test_a_robot_of_a_size_that_makes_no_sense_is_refused(tmp_path):
    far = ARM_URDF.replace("0 0 .5", "0 0 45").replace('xyz=".25 0 0"', 'xyz="0 0 30"')
    tiny = ARM_URDF
    for number in (".3 .3 .2", ".5 .05 .05", "0 0 .5", ".25 0 0"):
        tiny = tiny.replace(number, " ".join(f"{float(n) / 1000}" for n in number.split()))
    for text, message in ((far, "the whole robot is 75"), (tiny, "the whole robot is 0.0")):
        robot = load_robot(write_robot(tmp_path, urdf=text))
        with pytest.raises(RobotError, match=message):
            check_shapes(robot)


def test_a_joint_that_mimics_another_follows_it(tmp_path):
    grip = {"name": "grip", "joints": ["grip"], "unit": "m", "velocity": 0.1, "group": "hand"}
    start = {"turn": [0, 0], "grip": [0.01, 0.02]}
    arm = {"name": "turn", "joints": ["turn"], "unit": "rad", "velocity": 1.0, "group": "arm"}
    settings = {"dofs": [arm, grip], "start": start}
    robot = load_robot(write_robot(tmp_path, settings, GRIPPER_URDF))
    assert [joint.name for joint in robot.joints] == ["turn", "grip", "grip2"]
    drawn = robot.draw_joints(np.random.default_rng(0))
    assert drawn[2] == pytest.approx(-2 * drawn[1] + 0.01)
    assert robot.limits[1:] == pytest.approx(np.array([[0, 0.04], [-0.07, 0.01]]))
    parameters, _ = make_controller(robot)
    assert parameters.ratio.tolist() == [1, 1, -2]
    listed = {**settings, "dofs": [arm, {**grip, "joints": ["grip", "grip2"]}]}
    assert load_robot(write_robot(tmp_path, listed, GRIPPER_URDF)).followers.keys() == {"grip2"}
    own = {**settings, "dofs": [arm, {**grip, "joints": ["grip", "grip2"], "ratio": {"grip2": 3}}]}
    robot = load_robot(write_robot(tmp_path, own, GRIPPER_URDF))
    assert not robot.followers and robot.ratio_of_joint["grip2"] == 3
    alone = load_robot(write_robot(tmp_path, {}, GRIPPER_URDF))
    assert alone.fixed_position(alone.urdf.joints["grip2"]) == pytest.approx(0.01)


def test_a_joint_that_mimics_nothing_moves_by_itself(tmp_path):
    text = ARM_URDF.replace("<limit", '<mimic joint="gone"/><limit')
    robot = load_robot(write_robot(tmp_path, {}, text))
    assert robot.urdf.joints["turn"].mimic is None and "'gone'" in robot.urdf.notes[0]


def test_limits_that_are_both_zero_are_told(tmp_path):
    text = ARM_URDF.replace('lower="-2" upper="2"', 'effort="1"')
    with pytest.raises(RobotError, match=r"its limits in mine\.urdf are both 0; write lower"):
        load_robot(write_robot(tmp_path, {"start": {}}, text))


def test_a_moment_of_inertia_that_no_link_has_is_reduced():
    link = Link("a", 1e-3, np.zeros(3), np.eye(3) * 1e6, (), ())
    mass, _, moments = merge_inertials([(link, np.eye(4))])
    assert moments.max() <= mass * 3**2
