"""A robot in an apartment as a world: what it observes, and where it starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sensory_commutativity.scp.experiment import endings_per_dof
from sensory_commutativity.scp.world import World
from sensory_commutativity.worlds.apartment.physics.starts import StartError, draw_start
from sensory_commutativity.worlds.apartment.rendering.camera import Camera
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from sensory_commutativity.worlds.apartment.scenes.scene import Area, Fixture, Scene
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene
from sensory_commutativity.worlds.apartment.world import ApartmentWorld
from tests.helpers import ROOT
from tests.worlds.apartment.examples import ROBOTS, make_fixture, make_scene, write_robot

SMALL = Camera(32, 32, 90.0, 2)


@pytest.fixture(scope="module")
def empty():
    """A robot on an endless floor without collision shape."""
    (plate,) = make_fixture("floor", (30.0, 30.0, 0.01), (0.0, 0.0, -0.01)).parts
    floor = Fixture("floor", (replace(plate, texture="checker"),), ())
    world = ApartmentWorld(make_scene((floor,)), load_robot(ROBOTS / "jackrabbot.yaml"), (SMALL,))
    yield world
    world.simulation.close()


def test_starts_are_valid_reproducible_and_within_reach():
    scene = load_scene(ROOT / "config" / "apartments" / "rs-stand-in.yaml")
    cameras = Camera(32, 24, 90.0, 1), Camera(32, 24, 45.0, 1)
    world = ApartmentWorld(scene, load_robot(ROBOTS / "fetch.yaml"), cameras, within=0.3)
    assert isinstance(world, World)
    poses = []
    for seed in (0, 1, 2, 0):
        world.reset(np.random.default_rng(seed))
        assert not world.simulation.collisions.robot_penetrates(), seed
        assert not any(world.simulation.contact_counts()[1:]), seed
        world.restore(world.snapshot())
        assert world.happened().clearance < 0.3, seed
        poses.append(world.simulation.base())
    assert np.array_equal(poses[0], poses[3]) and not np.array_equal(poses[0], poses[1])
    assert world.observe().shape == (2, 24, 32, 3) and world.observe().dtype == np.uint8
    world.simulation.close()


def test_in_empty_space_both_orders_look_the_same(empty):
    ends = endings_per_dof(empty, 3, 15)
    assert list(ends) == [dof.name for dof in empty.dofs]
    for dof, (first, second) in ends.items():
        assert np.abs(first.observation.astype(int) - second.observation).max() <= 1, dof
        assert first.happened.touched_fixed == first.happened.touched_movable == 0, dof


def test_a_textured_floor_shows_the_motion_of_the_robot(empty):
    empty.reset(np.random.default_rng(0))
    before = empty.observe()
    action = np.zeros(7)
    action[:2] = 0.5
    for _ in range(4):
        empty.step(action)
    assert (before != empty.observe()).any(-1).mean() > 0.3


def test_a_robot_without_a_drive_is_restored_where_it_stood(tmp_path):
    world = ApartmentWorld(make_scene(), load_robot(write_robot(tmp_path)), (SMALL,))
    snapshots = []
    for seed in (0, 1):
        world.reset(np.random.default_rng(seed))
        snapshots.append((world.snapshot(), world.simulation.base(), world.observe()))
    for snapshot, base, image in snapshots:
        world.restore(snapshot)
        assert np.array_equal(world.simulation.base(), base)
        assert np.array_equal(world.observe(), image)
    assert not np.array_equal(snapshots[0][1], snapshots[1][1])
    world.simulation.close()


def test_without_cameras_the_world_has_the_field_of_view_of_the_robot():
    robot = load_robot(ROBOTS / "fetch.yaml")
    world = ApartmentWorld(make_scene(), robot)
    expected = robot.description.camera.field_of_view
    assert [camera.field_of_view for camera in world.cameras] == [expected]
    world.simulation.close()


def test_impossible_starts_are_reported(empty):
    block = make_fixture("block", (2.0, 2.0, 1.0), (0.0, 0.0, 1.0))
    full = Scene("full", (block,), (), (Area("room", (-1.0, 1.0), (-1.0, 1.0)),))
    robot = load_robot(ROBOTS / "jackrabbot.yaml")
    for scene, message in (
        (
            full,
            r"scene 'full' with robot 'jackrabbot': none of 20 random poses is a valid start "
            r"\(20 touch something",
        ),
        (Scene("none", (), (), ()), "no area in which a robot may start"),
    ):
        world = ApartmentWorld(scene, robot, (SMALL,))
        with pytest.raises(StartError, match=message):
            draw_start(world.simulation, np.random.default_rng(0), max_draws=20)
        world.simulation.close()
    with pytest.raises(StartError, match=r"in the others nothing is within 0\.2 m of the arm"):
        draw_start(empty.simulation, np.random.default_rng(0), within=0.2, max_draws=10)
