"""URDFs in xacro are expanded if the package is installed, and else reported."""

from __future__ import annotations

import sys

import pytest

from sensory_commutativity.worlds.apartment.robots.urdf import RobotError
from sensory_commutativity.worlds.apartment.robots.urdf_reader import read_urdf

XACRO = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="w" value="0.2"/>
  <xacro:macro name="part" params="name"><link name="${name}"><collision><geometry>
    <box size="${w} ${2 * w} 0.1"/></geometry></collision></link></xacro:macro>
  <xacro:part name="a"/><xacro:include filename="$(find own_description)/urdf/more.xacro"/>
</robot>"""
MORE = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:part name="b"/>
  <joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint></robot>"""


def test_xacro_is_expanded_with_the_files_that_it_includes(tmp_path):
    pytest.importorskip("xacro")
    folder = tmp_path / "own_description" / "urdf"
    folder.mkdir(parents=True)
    (folder.parent / "package.xml").write_text("<package><name>own_description</name></package>")
    (folder / "robot.urdf.xacro").write_text(XACRO)
    (folder / "more.xacro").write_text(MORE)
    urdf = read_urdf(folder / "robot.urdf.xacro")
    assert list(urdf.links) == ["a", "b"] and urdf.root == "a"
    assert urdf.links["b"].collisions[0].size == pytest.approx((0.1, 0.2, 0.05))
    (folder / "more.xacro").write_text("<robot>${nothing}</robot>")
    with pytest.raises(RobotError, match="cannot be expanded by xacro") as error:
        read_urdf(folder / "robot.urdf.xacro")
    assert "\n" not in str(error.value)


def test_without_the_package_xacro_is_reported(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "xacro", None)
    (tmp_path / "robot.urdf").write_text(XACRO)
    with pytest.raises(RobotError, match=r"pip install 'sensory-commutativity\[xacro\]'"):
        read_urdf(tmp_path / "robot.urdf")
