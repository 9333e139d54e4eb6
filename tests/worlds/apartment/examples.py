"""Robots and scenes that several test modules use."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from sensory_commutativity.worlds.apartment import geometry
from sensory_commutativity.worlds.apartment.scenes.scene import (
    Area,
    Fixture,
    Movable,
    Part,
    Scene,
    Solid,
    Vector,
)
from tests.helpers import ROOT

ROBOTS = ROOT / "config" / "robots"
ROOM = Area("room", (-2.0, 2.0), (-2.0, 2.0))

ARM_URDF = """<robot name="arm">
  <link name="foot">
    <inertial><mass value="3"/>
      <inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size=".3 .3 .2"/></geometry></collision>
  </link>
  <link name="rod">
    <inertial><origin xyz=".25 0 0"/><mass value="1"/>
      <inertia ixx=".01" iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz=".25 0 0"/><geometry><box size=".5 .05 .05"/></geometry>
      <material name="m"><color rgba="1 0 0 1"/></material></visual>
    <collision><origin xyz=".25 0 0"/><geometry><box size=".5 .05 .05"/></geometry></collision>
  </link>
  <link name="eye"/>
  <joint name="turn" type="revolute">
    <parent link="foot"/><child link="rod"/><origin xyz="0 0 .5"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2"/>
  </joint>
  <joint name="mount" type="fixed">
    <parent link="rod"/><child link="eye"/><origin xyz=".1 0 .2"/>
  </joint>
</robot>"""
"""An arm of one joint that is fixed to the floor."""

ARM: dict[str, Any] = {
    "name": "mine",
    "urdf": "mine.urdf",
    "start": {"turn": [-0.5, 0.5]},
    "dofs": [{"name": "turn", "joints": ["turn"], "unit": "rad", "velocity": 1.0, "group": "arm"}],
    "camera": {"link": "eye", "position": [0, 0, 0]},
}
"""Its description."""


def write_robot(
    folder: Path, description: dict[str, Any] | None = None, urdf: str = ARM_URDF
) -> Path:
    """Write the arm, with some keys of its description replaced; return the YAML file."""
    (folder / "mine.urdf").write_text(urdf)
    (folder / "mine.yaml").write_text(yaml.safe_dump({**ARM, **(description or {})}))
    return folder / "mine.yaml"


def make_fixture(name: str, half: Vector, position: Vector) -> Fixture:
    """Return a visible box of half size `half`, metres, that never moves."""
    mesh = geometry.transform(geometry.box(half), position)
    return Fixture(name, (Part(mesh, (1.0, 1.0, 1.0)),), (Solid("box", half, position),))


def make_object(name: str, half: float, position: Vector) -> Movable:
    """Return a movable cube of half size `half`, metres, and 2 kg."""
    sizes = (half, half, half)
    part = Part(geometry.box(sizes), (1.0, 1.0, 1.0))
    return Movable(name, "box", 2.0, (part,), (Solid("box", sizes),), position)


def make_scene(
    fixtures: tuple[Fixture, ...] = (), movables: tuple[Movable, ...] = (), name: str = "room"
) -> Scene:
    """Return a scene with one area of 4 m x 4 m, in which a robot may start."""
    return Scene(name, fixtures, movables, (ROOM,))
