"""What the configuration of the objects study names: scenes, test runs, models and the map.

This module is read by the workflow before every job, so it imports nothing heavy at the top.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ...errors import ConfigError
from ...seeding import generator, seed_for
from ..apartment.builders import build_scene, contents
from ..config import Config
from .config import LEARNED, MaskModelConfig, ViewClassifierConfig

if TYPE_CHECKING:
    from ...change_detection.simulated.poses import Pose
    from ...change_detection.simulated.scene_sampler import SceneSampler
    from ...change_detection.training.trainer import TrainingSettings
    from ...worlds.apartment.rendering.camera import Camera
    from ...worlds.apartment.robots.robot import Robot
    from ...worlds.apartment.scenes.scene import Scene

MODELS = (*LEARNED, "difference")
"""The models that learn, and the image difference, which does not."""
TEST_STREAM = "last tests"
"""Key of the random streams of the tests. Tuples of an older stream, "tests", in the same
apartments with objects of the same families, were looked at during development."""


class TupleRun(NamedTuple):
    """SC-experiments that are played once and seen through one or two cameras, each of which makes
    a test set.

    Attributes
    ----------
    name : str
    scenes : tuple of str
        Apartments; cluttered scenes take them in turn.
    family : str
        Of the objects: ``training`` or ``testing``.
    sets : dict
        Name of a test set -> vertical field of view, degrees.
    alternatives : bool
        Whether the alternatives to SC-experiments are played, too.
    """

    name: str
    scenes: tuple[str, ...]
    family: Any
    sets: dict[str, float]
    alternatives: bool


def tuple_runs(config: Config) -> dict[str, TupleRun]:
    """The test runs: nothing new; one of three things new; all three new."""
    data, tests = config.masks.data, config.masks.tests
    trained, untrained = (data.scene,), tuple(tests.scenes)
    narrow, wide = data.field_of_view, tests.field_of_view
    runs = (
        TupleRun(
            "as-trained", trained, "training", {"as-trained": narrow, "other-view": wide}, True
        ),
        TupleRun("other-objects", trained, "testing", {"other-objects": narrow}, False),
        TupleRun("other-apartments", untrained, "training", {"other-apartments": narrow}, False),
        TupleRun("all-other", untrained, "testing", {"all-other": wide}, False),
    )
    return {run.name: run for run in runs}


def test_set_names(config: Config) -> list[str]:
    """Names of all test sets."""
    return [name for run in tuple_runs(config).values() for name in run.sets]


def trained_models(config: Config) -> dict[str, int]:
    """The models that learn, as runs that are never cut."""
    return dict.fromkeys(LEARNED, 1)


# ---- cluttered scenes -------------------------------------------------------------------------


def count_pair_scenes(config: Config) -> dict[str, int]:
    """Split -> number of cluttered scenes in which its pairs are made."""
    data = config.masks.data
    return {
        "training": math.ceil(data.pairs / data.pairs_per_scene),
        "validation": math.ceil(data.validation_pairs / data.pairs_per_scene),
    }


def pairs_in_scene(config: Config, split: str, scene: int) -> int:
    """How many pairs of each outcome are made in a scene."""
    data = config.masks.data
    pairs = data.pairs if split == "training" else data.validation_pairs
    return min(data.pairs_per_scene, pairs - scene * data.pairs_per_scene)


def count_test_scenes(config: Config) -> int:
    """Number of cluttered scenes of each test run."""
    return math.ceil(config.masks.tests.experiments / config.masks.tests.experiments_per_scene)


def experiments_in_scene(config: Config, scene: int) -> int:
    """How many SC-experiments are played in a scene."""
    tests = config.masks.tests
    return min(tests.experiments_per_scene, tests.experiments - scene * tests.experiments_per_scene)


def make_pair_sampler(config: Config, split: str, scene: int) -> SceneSampler:
    """Where the pairs of a scene are made; objects and rooms in many colours and sizes."""
    from ...change_detection.simulated.scene_sampler import SceneSampler  # imports PyBullet

    data = config.masks.data
    return SceneSampler(
        load_named_scene(config, data.scene),
        load_masks_robot(config),
        make_masks_cameras(config, [data.field_of_view]),
        "training",
        generator(config.seed, "masks", "pairs", split, scene),
        config.masks.objects,
    )


def make_test_sampler(config: Config, run: TupleRun, scene: int) -> SceneSampler:
    """Where the SC-experiments of a scene are played; objects and rooms as they are."""
    from ...change_detection.simulated.scene_sampler import SceneSampler  # imports PyBullet

    return SceneSampler(
        load_named_scene(config, run.scenes[scene % len(run.scenes)]),
        load_masks_robot(config),
        make_masks_cameras(config, list(run.sets.values())),
        run.family,
        generator(config.seed, "masks", TEST_STREAM, run.name, scene),
        config.masks.objects,
        randomize_appearance=False,
    )


# ---- robot, cameras, map ----------------------------------------------------------------------


def load_masks_robot(config: Config) -> Robot:
    """The robot, with its fixed joints at the positions of masks.fixed. Raises RobotError."""
    from ...worlds.apartment.robots.loading import load_robot, set_fixed_joints

    masks = config.masks
    robot = load_robot(config.apartment.robots[masks.robot].description)
    return set_fixed_joints(robot, masks.fixed, "masks")


def load_named_scene(config: Config, name: str) -> Scene:
    """The scene that apartment.scenes.`name` describes."""
    return build_scene(config.apartment, name)


def make_masks_cameras(config: Config, fields_of_view: Sequence[float]) -> list[Camera]:
    """A camera for each vertical field of view, degrees."""
    from ...worlds.apartment.rendering.camera import Camera

    size = config.masks.image_size
    return [Camera(size, size, view, config.apartment.supersampling) for view in fields_of_view]


def map_poses(config: Config) -> list[Pose]:
    """The poses at which the local SCP is measured."""
    from ...change_detection.simulated.poses import grid_poses

    settings = config.masks.map
    return grid_poses(load_named_scene(config, settings.scene), settings.spacing, settings.headings)


def find_first_arm_dof(robot: Robot) -> int:
    """Index, in the action vector, of the arm joint nearest the body.

    Raises
    ------
    ConfigError
        If there is none.
    """
    revolute = [joint.name for joint in robot.joints if joint.kind != "prismatic"]
    for k, dof in enumerate(robot.description.dofs):
        if revolute and revolute[0] in dof.joints:
            return k
    raise ConfigError(
        f"masks.robot: {robot.description.name!r} has no arm, i.e. no revolute joint that is no "
        "wheel; choose another robot"
    )


# ---- training ---------------------------------------------------------------------------------


def optimizer_settings(settings: MaskModelConfig | ViewClassifierConfig) -> TrainingSettings:
    """How a network is trained."""
    from ...change_detection.training.trainer import TrainingSettings  # imports torch

    return TrainingSettings(
        settings.samples, settings.batch_size, settings.learning_rate, settings.weight_decay
    )


def training_seed(config: Config) -> int:
    """Seed of initial weights, order and augmentation."""
    return seed_for(config.seed, "masks", "training")


# ---- settings that results depend on ----------------------------------------------------------


def described_robot(config: Config) -> tuple[str, ...]:
    """Contents of the files that describe the robot."""
    return contents(config.apartment.robots[config.masks.robot].description, "robot")


def _simulation_settings(config: Config, scenes: Sequence[str]) -> list[Any]:
    """Robot, apartments and camera, common to everything that is simulated."""
    masks, apartment = config.masks, config.apartment
    files = [contents(apartment.scenes[scene].file, "scene") for scene in scenes]
    return [described_robot(config), list(scenes), files, masks.fixed, masks.image_size,
            apartment.supersampling]  # fmt: skip


def data_settings(config: Config) -> list[Any]:
    """Everything that pairs depend on, apart from their split and number."""
    masks = config.masks
    return [*_simulation_settings(config, [masks.data.scene]), masks.objects,
            masks.data.field_of_view, masks.data.pairs_per_scene]  # fmt: skip


def tuple_settings(config: Config, run: str) -> list[Any]:
    """Everything that the SC-experiments of a test run depend on, apart from the degree of freedom
    and their number."""
    tests, tuple_run = config.masks.tests, tuple_runs(config)[run]
    return [TEST_STREAM, *_simulation_settings(config, tuple_run.scenes), list(tuple_run),
            config.masks.objects, config.apartment.rest_steps, tests.sequence_length,
            tests.experiments_per_scene]  # fmt: skip


def map_settings(config: Config) -> list[Any]:
    """Everything that the experiments of the map depend on."""
    masks, settings = config.masks, config.masks.map
    return [*_simulation_settings(config, [settings.scene]),
            {**settings.settings_that_affect_results(), "cramped_room": None},
            masks.data.field_of_view,
            config.apartment.rest_steps]  # fmt: skip


def training_settings(config: Config, model: str) -> MaskModelConfig:
    """Everything that a trained model depends on, apart from its pairs."""
    return config.masks.model(model)  # type: ignore[arg-type]  # one of LEARNED


def check_masks(config: Config) -> None:
    """Check what can be known before any job: joints, rooms and furniture that are named exist.

    Raises
    ------
    UserError
    """
    find_first_arm_dof(load_masks_robot(config))
    settings = config.masks.map
    scene = load_named_scene(config, settings.scene)
    rooms = [area.name for area in scene.areas]
    fixtures = {fixture.name for fixture in scene.fixtures}
    if settings.cramped_room not in rooms:
        raise ConfigError(
            f"masks.map.cramped_room: {settings.scene!r} has no room {settings.cramped_room!r}; "
            f"choose one of {', '.join(rooms)}"
        )
    for name in settings.low_furniture:
        if name not in fixtures:
            raise ConfigError(
                f"masks.map.low_furniture: {settings.scene!r} has no furniture {name!r}; "
                "name furniture of its floor plan"
            )
