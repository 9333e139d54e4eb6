"""A robot in an apartment as a world: it promises what every world does, starts where it should, and says so when it cannot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sensory_commutativity.helpers import DEFAULT
from sensory_commutativity.test_apartment_robot import written as write_robot
from sensory_commutativity.test_apartment_scenes import room_mesh
from sensory_commutativity.test_apartment_scenes import written as write_scene

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.perceptual.weights import Weights, WeightsError
from sensory_commutativity.scp.experiment import endings_per_dof
from sensory_commutativity.scp.world import World
from sensory_commutativity.storage.tables import TABLES
from sensory_commutativity.studies.apartment.builders import (
    apartment_world,
    check_apartment,
    check_ready,
    contents,
    empty_floor,
)
from sensory_commutativity.studies.apartment.tables.apartment_experiments import run_experiments
from sensory_commutativity.studies.loading import load, merge, validate
from sensory_commutativity.worlds.apartment.physics.starts import StartError, draw_start
from sensory_commutativity.worlds.apartment.rendering.camera import Camera
from sensory_commutativity.worlds.apartment.robots.robot import load_robot
from sensory_commutativity.worlds.apartment.scenes.scene import Area, Fixture, Scene, Solid
from sensory_commutativity.worlds.apartment.world import ApartmentWorld

ROBOTS = Path(__file__).parents[2] / "config" / "robots"
SMALL = Camera(32, 32, 90.0, 2)


class CountedPixels:
    """Stands in for VGG16 where only the plumbing is tested: the number of unequal pixels."""

    def distances(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return (first != second).any(-1).sum((1, 2)).astype(float)


@pytest.fixture(scope="module")
def config():
    return load(DEFAULT)


@pytest.fixture(scope="module")
def home(config):
    world = apartment_world(config, "fetch", "rs-stand-in", "anywhere", (90.0, 45.0))
    yield world
    world.simulation.close()


@pytest.fixture(scope="module")
def floor():
    world = ApartmentWorld(empty_floor("free"), load_robot(ROBOTS / "jackrabbot.yaml"), (SMALL,))
    yield world
    world.simulation.close()


def test_it_is_a_world_and_starts_are_valid_and_reproducible(home):
    assert isinstance(home, World)
    poses = []
    for seed in (0, 1, 0):
        home.reset(np.random.default_rng(seed))
        assert not home.simulation.penetrates() and not any(home.simulation.touches()[1:])
        poses.append(home.simulation.base())
    assert np.array_equal(poses[0], poses[2]) and not np.array_equal(poses[0], poses[1])
    assert home.observe().shape == (2, 128, 128, 3) and home.observe().dtype == np.uint8


def test_starts_within_reach_have_something_near_the_arm(config):
    world = apartment_world(config, "fetch", "rs-stand-in", "within-reach")
    for seed in range(5):
        world.reset(np.random.default_rng(seed))
        start = world.snapshot()
        world.restore(start)
        assert world.happened().clearance < config.apartment.reach
    world.simulation.close()


def test_in_empty_space_both_orders_look_the_same(floor):
    ends = endings_per_dof(floor, 3, 15)
    assert list(ends) == [dof.name for dof in floor.dofs]
    for dof, (one, other) in ends.items():
        assert np.abs(one.observation.astype(int) - other.observation).max() <= 1, dof
        assert one.happened.touched_fixed == one.happened.touched_movable == 0


def test_an_empty_floor_shows_where_the_robot_is(floor):
    floor.reset(np.random.default_rng(0))
    before = floor.observe()
    action = np.zeros(7)
    action[:2] = 0.5
    for _ in range(4):
        floor.step(action)
    assert (before != floor.observe()).any(-1).mean() > 0.3


def test_experiments_do_not_depend_on_how_they_are_cut(config, home):
    run = config.apartment.runs()[0]._replace(length=6)
    features = CountedPixels()
    whole = run_experiments(config, run, home, features, 0, 3)
    parts = [run_experiments(config, run, home, features, i, i + 1) for i in (2, 0, 1)]
    assert list(whole.columns) == [column.name for column in TABLES["apartment_experiments"]]
    for i, part in zip((2, 0, 1), parts, strict=True):
        expected = whole[whole["experiment"] == i].reset_index(drop=True)
        assert expected.equals(part.reset_index(drop=True))


def test_a_users_own_robot_in_a_users_own_rooms(tmp_path, config):
    """A fixed arm from a URDF, in a room from a mesh, by files and configuration alone."""
    write_robot(tmp_path, {"start": {"turn": [-0.5, 0.5]}})
    room_mesh().export(tmp_path / "room.ply")
    write_scene(tmp_path, {"kind": "mesh", "name": "mine", "mesh": "room.ply"})
    change = {
        "robots": {"mine": {"description": str(tmp_path / "mine.yaml")}},
        "scenes": {"mine": {"file": str(tmp_path / "scene.yaml")}},
    }
    settings = validate(merge(config.model_dump(mode="json"), {"apartment": change}))
    check_apartment(settings)
    world = apartment_world(settings, "mine", "mine", "anywhere")
    world.reset(np.random.default_rng(2))
    assert np.abs(world.simulation.base()[:2]).max() < 2
    before = world.observe()
    world.step(np.array([1.0]))
    world.step(np.array([0.0]))
    assert world.simulation.joints()[0] != 0 and (before != world.observe()).any()
    world.simulation.close()


def test_a_robot_that_fits_nowhere_is_told():
    full = Fixture("block", (), (Solid("box", (2.0, 2.0, 1.0), (0.0, 0.0, 1.0)),))
    robot = load_robot(ROBOTS / "jackrabbot.yaml")
    world = ApartmentWorld(
        Scene("full", (full,), (), (Area("room", (-1, 1), (-1, 1)),)), robot, (SMALL,)
    )
    with pytest.raises(
        StartError,
        match=r"scene 'full' with robot 'jackrabbot': none of 20 random places is a valid start \(20 touch something\)",
    ):
        draw_start(world.simulation, np.random.default_rng(0), tries=20)
    world.simulation.close()


def test_nothing_within_reach_is_told(floor):
    with pytest.raises(StartError, match=r"in the others nothing is within 0\.2 m of the arm"):
        draw_start(floor.simulation, np.random.default_rng(0), within=0.2, tries=10)


def test_a_scene_without_areas_is_told():
    world = ApartmentWorld(
        Scene("none", (), (), ()), load_robot(ROBOTS / "jackrabbot.yaml"), (SMALL,)
    )
    with pytest.raises(StartError, match="no area in which a robot may start"):
        world.reset(np.random.default_rng(0))
    world.simulation.close()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robots": {"fetch": {"description": "none.yaml"}}}, "none.yaml: there is no such file"),
        ({"scenes": {"rs-stand-in": {"file": "none.yaml"}}}, "none.yaml: there is no such file"),
    ],
)
def test_a_file_that_is_not_there_is_told_before_any_work(config, change, message):
    settings = validate(merge(config.model_dump(mode="json"), {"apartment": change}))
    with pytest.raises(Exception, match=message):
        check_apartment(settings)


def test_what_only_trying_can_tell_is_told_with_its_key_before_the_long_work(
    tmp_path, config, monkeypatch
):
    (tmp_path / "full.yaml").write_text(
        "kind: floor-plan\nname: full\nrooms: {room: {x: [0.0, 1.2], y: [0.0, 1.2]}}\n"
        "furniture: [{type: table, name: block, at: [0.6, 0.6], size: [1.0, 1.0, 0.7]}]\n"
    )
    monkeypatch.setattr(
        "sensory_commutativity.studies.apartment.builders.vgg16_weights",
        lambda file: Weights((), "made up"),
    )
    monkeypatch.setattr("sensory_commutativity.worlds.apartment.physics.starts.TRIES", 20)
    change = {"scenes": {"rs-stand-in": {"file": str(tmp_path / "full.yaml")}}}
    settings = validate(merge(config.model_dump(mode="json"), {"apartment": change}))
    with pytest.raises(
        ConfigError,
        match=r"config: apartment\.robots\.fetch in apartment\.scenes\.rs-stand-in: scene 'full'.* is a valid start",
    ):
        check_ready(settings, "fetch", "rs-stand-in", "anywhere")


def test_weights_that_cannot_be_had_are_told_before_the_long_work(config):
    settings = validate(
        merge(config.model_dump(mode="json"), {"apartment": {"weights": "nowhere/vgg16.npz"}})
    )
    with pytest.raises(
        WeightsError, match=r"apartment\.weights: there is no file nowhere/vgg16\.npz"
    ):
        check_ready(settings, "fetch", "rs-stand-in", "anywhere")


def test_a_robot_fixed_to_the_floor_is_put_back_where_it_stood(tmp_path):
    write_robot(tmp_path, {"start": {"turn": [-0.5, 0.5]}})
    world = ApartmentWorld(empty_floor("free"), load_robot(tmp_path / "mine.yaml"), (SMALL,))
    places = []
    for seed in (0, 1):
        world.reset(np.random.default_rng(seed))
        places.append((world.snapshot(), world.simulation.base(), world.observe()))
    for start, base, seen in places:
        world.restore(start)
        assert np.array_equal(world.simulation.base(), base) and np.array_equal(
            world.observe(), seen
        )
    assert not np.array_equal(places[0][1], places[1][1])
    world.simulation.close()


def test_a_world_sees_as_wide_as_its_robot_says():
    robot = load_robot(ROBOTS / "fetch.yaml")
    world = ApartmentWorld(empty_floor("free"), robot)
    assert [camera.field_of_view for camera in world.cameras] == [
        robot.description.camera.field_of_view
    ]
    world.simulation.close()


def test_what_a_run_depends_on_is_hashed_down_to_the_urdf(tmp_path, config):
    write_robot(tmp_path, {"start": {"turn": [-0.5, 0.5]}})
    before = contents(str(tmp_path / "mine.yaml"), "robot")
    urdf = load_robot(tmp_path / "mine.yaml").urdf.path
    urdf.write_text(urdf.read_text() + "<!-- changed -->")
    contents.cache_clear()
    after = contents(str(tmp_path / "mine.yaml"), "robot")
    assert before[0] == after[0] and before[1] != after[1]


def test_free_space_must_be_free(config):
    with pytest.raises(
        ConfigError, match=r"free_space\.scenes names 'rs-stand-in', which has a file"
    ):
        validate(
            merge(
                config.model_dump(mode="json"),
                {"apartment": {"free_space": {"scenes": ["rs-stand-in"]}}},
            )
        )
