"""What the configuration of the apartment study describes, and how its files are checked."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sensory_commutativity.errors import ConfigError, UserError
from sensory_commutativity.perceptual.weights import Weights, WeightsError
from sensory_commutativity.studies.apartment.builders import (
    apartment_world,
    build_run_world,
    check_apartment,
    check_ready,
    contents,
)
from sensory_commutativity.studies.apartment.tables.apartment_experiments import (
    apartment_experiments,
    run_experiments,
)
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import merge, validate
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from tests.worlds.apartment.examples import write_robot


class PixelDistance:
    """A fast replacement of the VGG16 features: the number of unequal pixels."""

    def distances(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return (first != second).any(-1).sum((1, 2)).astype(float)


def overlay(config: Config, **apartment) -> Config:
    return validate(merge(config.model_dump(mode="json"), {"apartment": apartment}))


def test_experiments_do_not_depend_on_how_they_are_split(default_config):
    config = overlay(default_config, sequence_length=6)
    run, features = config.apartment.runs()[0], PixelDistance()
    world = build_run_world(config, run)
    whole = run_experiments(config, run, world, features, 0, 3)
    assert list(whole.columns) == list(apartment_experiments.column_names)
    for i in (2, 0, 1):
        part = run_experiments(config, run, world, features, i, i + 1)
        expected = whole[whole["experiment"] == i].reset_index(drop=True)
        assert expected.equals(part.reset_index(drop=True)), i
    world.simulation.close()


def test_a_users_own_robot_in_a_users_own_rooms(tmp_path, default_config):
    """An arm fixed to the floor in a room from a mesh file, by files and configuration alone."""
    write_robot(tmp_path)
    floor = trimesh.creation.box((4.0, 3.0, 0.1))
    wall = trimesh.creation.box((0.1, 3.0, 2.4)).apply_translation((2.0, 0.0, 1.2))
    trimesh.util.concatenate([floor, wall]).export(tmp_path / "room.ply")
    (tmp_path / "scene.yaml").write_text("kind: mesh\nname: mine\nmesh: room.ply\n")
    config = overlay(
        default_config,
        robots={"mine": {"description": str(tmp_path / "mine.yaml")}},
        scenes={"mine": {"file": str(tmp_path / "scene.yaml")}},
    )
    check_apartment(config)
    world = apartment_world(config, "mine", "mine", "anywhere")
    world.reset(np.random.default_rng(2))
    assert np.abs(world.simulation.base()[:2]).max() < 2
    before = world.observe()
    world.step(np.array([1.0]))
    world.step(np.array([0.0]))
    assert world.simulation.joints()[0] != 0 and (before != world.observe()).any()
    world.simulation.close()


def test_missing_files_are_reported_before_any_work(default_config):
    missing = "none.yaml: there is no such file"
    for change in (
        {"robots": {"fetch": {"description": "none.yaml"}}},
        {"scenes": {"rs-stand-in": {"file": "none.yaml"}}},
    ):
        with pytest.raises(UserError, match=missing):
            check_apartment(overlay(default_config, **change))
    weights = overlay(default_config, weights="nowhere/vgg16.npz")
    message = r"apartment\.weights: there is no file '?nowhere/vgg16\.npz"
    with pytest.raises(WeightsError, match=message):
        check_apartment(weights)
    with pytest.raises(WeightsError, match=r"nowhere/vgg16\.npz: there is no such file"):
        check_ready(weights, "fetch", "rs-stand-in", "anywhere")


def test_a_robot_without_a_valid_start_is_reported_with_its_key(
    tmp_path, default_config, monkeypatch
):
    (tmp_path / "full.yaml").write_text(
        "kind: floor-plan\nname: full\nrooms: {room: {x: [0.0, 1.2], y: [0.0, 1.2]}}\n"
        "furniture: [{type: table, name: block, at: [0.6, 0.6], size: [1.0, 1.0, 0.7]}]\n"
    )
    monkeypatch.setattr(
        "sensory_commutativity.perceptual.weights.load_vgg16_weights",
        lambda file: Weights((), "made up"),
    )
    monkeypatch.setattr("sensory_commutativity.worlds.apartment.physics.starts.MAX_DRAWS", 20)
    config = overlay(default_config, scenes={"rs-stand-in": {"file": str(tmp_path / "full.yaml")}})
    message = (
        r"config: apartment\.robots\.fetch in apartment\.scenes\.rs-stand-in: "
        "scene 'full'.* is a valid start"
    )
    with pytest.raises(ConfigError, match=message):
        check_ready(config, "fetch", "rs-stand-in", "anywhere")


def test_settings_of_results_include_the_contents_of_the_urdf(tmp_path):
    file = write_robot(tmp_path)
    before = contents(str(file), "robot")
    urdf = load_robot(file).urdf.path
    urdf.write_text(urdf.read_text() + "<!-- changed -->")
    contents.cache_clear()
    after = contents(str(file), "robot")
    assert before[0] == after[0] and before[1] != after[1]


def test_free_space_must_be_free(default_config):
    message = r"free_space\.scenes names 'rs-stand-in', which has a file"
    with pytest.raises(ConfigError, match=message):
        overlay(default_config, free_space={"scenes": ["rs-stand-in"]})
