"""The households, tests and trainings that the configuration asks for."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple

from ...change_detection.simulated.poses import Pose, grid_poses
from ...errors import ConfigError
from ...seeding import generator, seed_for
from ...worlds.apartment.robots.robot import Robot, load_robot, with_fixed
from ...worlds.apartment.scenes.objects import Family
from ..apartment.builders import contents, scene_of
from ..config import Config
from .config import ModelName

if TYPE_CHECKING:  # the workflow reads this module before every job: nothing heavy
    import pandas as pd

    from ...change_detection.simulated.scene_sampler import SceneSampler
    from ...change_detection.training.trainer import TrainingSettings
    from ...worlds.apartment.rendering.camera import Camera
    from .config import MaskModelConfig, ViewClassifierConfig

Split = Literal["training", "validation"]
TEST_STREAM = "last tests"
"""What the random numbers of the tests follow from. Tuples of an older stream, "tests", in the same apartments with objects of the same families,
were looked at while training and prediction were still being changed."""


class TupleRun(NamedTuple):
    """SC-experiments that are played once and looked at through one or two cameras, each of which makes a test set.

    Attributes
    ----------
    name : str
    scenes : tuple of str
        Jobs take them in turn.
    family : str
        Which objects.
    sets : dict
        Name of a test set -> field of view, degrees.
    alternatives : bool
        Whether the alternatives to SC-experiments are played, too.
    """

    name: str
    scenes: tuple[str, ...]
    family: Family
    sets: dict[str, float]
    alternatives: bool


def tuple_runs(config: Config) -> dict[str, TupleRun]:
    """All of them: nothing new; each of three things new; all three new."""
    data, tests = config.masks.data, config.masks.tests
    here, there = (data.scene,), tuple(tests.scenes)
    near, far = data.field_of_view, tests.field_of_view
    runs = (
        TupleRun("as-trained", here, "training", {"as-trained": near, "other-view": far}, True),
        TupleRun("other-objects", here, "testing", {"other-objects": near}, False),
        TupleRun("other-apartments", there, "training", {"other-apartments": near}, False),
        TupleRun("all-other", there, "testing", {"all-other": far}, False),
    )
    return {run.name: run for run in runs}


def names_of_test_sets(config: Config) -> list[str]:
    """Names of all test sets."""
    return [name for run in tuple_runs(config).values() for name in run.sets]


def tuple_jobs(config: Config) -> int:
    """Into how many jobs each run of SC-experiments is cut."""
    return math.ceil(config.masks.tests.experiments / config.masks.tests.experiments_per_job)


def places_of_map(config: Config) -> list[Pose]:
    """Where the local SCP is measured."""
    settings = config.masks.map
    return grid_poses(
        scene_of(config.apartment, settings.scene), settings.spacing, settings.headings
    )


def map_jobs(config: Config) -> int:
    """Into how many jobs they are cut."""
    return math.ceil(len(places_of_map(config)) / config.masks.map.poses_per_job)


def robot_of_masks(config: Config) -> Robot:
    """The robot, its fixed joints where masks.fixed puts them. Raises RobotError."""
    masks = config.masks
    return with_fixed(
        load_robot(config.apartment.robots[masks.robot].description), masks.fixed, "masks"
    )


def cameras_of_masks(config: Config, fields_of_view: Sequence[float]) -> list[Camera]:
    """A camera for each field of view, degrees."""
    from ...worlds.apartment.rendering.camera import Camera

    size = config.masks.image_size
    return [Camera(size, size, view, config.apartment.supersampling) for view in fields_of_view]


def household_of_pairs(config: Config, split: Split, job: int) -> SceneSampler:
    """Where the pairs of a job are made; objects and rooms in many colours and sizes."""
    from ...change_detection.simulated.scene_sampler import (
        SceneSampler,  # imports PyBullet, which checking a configuration does not need
    )

    data, rng = config.masks.data, generator(config.seed, "masks", "pairs", split, job)
    scene = scene_of(config.apartment, data.scene)
    return SceneSampler(
        scene,
        robot_of_masks(config),
        cameras_of_masks(config, [data.field_of_view]),
        "training",
        rng,
        config.masks.objects,
    )


def household_of_tests(config: Config, run: TupleRun, job: int) -> SceneSampler:
    """Where the SC-experiments of a job are played; objects and rooms as they are."""
    from ...change_detection.simulated.scene_sampler import SceneSampler

    rng, scene = (
        generator(config.seed, "masks", TEST_STREAM, run.name, job),
        run.scenes[job % len(run.scenes)],
    )
    cameras = cameras_of_masks(config, list(run.sets.values()))
    return SceneSampler(
        scene_of(config.apartment, scene),
        robot_of_masks(config),
        cameras,
        run.family,
        rng,
        config.masks.objects,
        varied=False,
    )


def recipe_of(config: Config, model: ModelName) -> TrainingSettings:
    """How a model is trained."""
    return _recipe(config.masks.model(model))


def recipe_of_judge(config: Config) -> TrainingSettings:
    """How a judge of places is trained."""
    return _recipe(config.masks.view_classifier)


def training_seed(config: Config) -> int:
    """What weights, order and augmentation follow from."""
    return seed_for(config.seed, "masks", "training")


def dof_nearest_half(scp: pd.DataFrame, config: Config) -> tuple[str, float]:
    """The degree of freedom of the arm whose SCP in the reference is nearest .5 (paper, section IV-A), and its SCP.

    `scp` is an apartment_scp table. Wheels and lifts are left out: they move the camera, and hardly any outcome would be but "different".
    """
    settings = config.apartment
    reference = settings.reference
    rows = scp[
        (scp["robot"] == reference.robot)
        & (scp["apartment"] == reference.scene)
        & (scp["start"] == "anywhere")
    ]
    rows = rows[
        (rows["length"] == settings.sequence_length) & (rows["threshold"] == reference.threshold)
    ]
    rows = rows[rows["field_of_view"] == settings.fields_of_view[0]].set_index("dof")["scp"]
    robot = robot_of_masks(config)
    arm = [
        dof.name
        for dof in robot.description.dofs
        if dof.unit == "rad" and not set(dof.joints) & set(robot.wheels)
    ]
    nearest = (rows[arm] - 0.5).abs().idxmin()
    return str(nearest), float(rows[nearest])


def first_of_arm(robot: Robot) -> int:
    """Pose, in the action vector, of the arm joint nearest the body. Raises ConfigError where there is none."""
    turning = [joint.name for joint in robot.joints if joint.kind != "prismatic"]
    found = next(
        (k for k, dof in enumerate(robot.description.dofs) if turning and turning[0] in dof.joints),
        None,
    )
    if found is None:
        raise ConfigError(
            f"masks.robot: {robot.description.name!r} has no arm, i.e. no joint that turns and is no wheel; choose another robot"
        )
    return found


def pairs_of_job(config: Config, split: Split, job: int) -> int:
    """How many pairs of each outcome a job makes."""
    data = config.masks.data
    return min(
        data.pairs_per_job,
        (data.pairs if split == "training" else data.validation_pairs) - job * data.pairs_per_job,
    )


def experiments_of_job(config: Config, job: int) -> int:
    """How many SC-experiments a job plays."""
    tests = config.masks.tests
    return min(tests.experiments_per_job, tests.experiments - job * tests.experiments_per_job)


def settings_of_data(config: Config) -> str:
    """Everything that pairs depend on but their split and number, as JSON."""
    masks, apartment = config.masks, config.apartment
    return json.dumps([*_files(config, [masks.data.scene]), masks.fixed, masks.image_size, masks.objects, apartment.supersampling, config.seed,
                       masks.data.scene, masks.data.field_of_view, masks.data.pairs_per_job])  # fmt: skip


def settings_of_tests(config: Config, run: TupleRun) -> str:
    """Everything that the SC-experiments of a run depend on but the degree of freedom and their number, as JSON."""
    masks, apartment = config.masks, config.apartment
    return json.dumps([TEST_STREAM, *_files(config, run.scenes), run, masks.fixed, masks.image_size, masks.objects, apartment.supersampling,
                       config.seed, masks.tests.sequence_length, masks.tests.experiments_per_job])  # fmt: skip


def settings_of_map(config: Config) -> str:
    """Everything that the local SCP at a place depends on but the predictor and the degree of freedom, as JSON."""
    masks, apartment = config.masks, config.apartment
    return json.dumps([*_files(config, [masks.map.scene]), masks.map.model_dump(mode="json", exclude={"cramped_room"}), masks.fixed, masks.image_size,
                       masks.data.field_of_view, apartment.supersampling, config.seed])  # fmt: skip


def settings_of_training(config: Config, model: ModelName) -> str:
    """Everything that a trained model depends on, as JSON."""
    settings = config.masks.model(model).model_dump(mode="json")
    return json.dumps(
        [
            settings_of_data(config),
            config.masks.data.pairs,
            config.masks.data.validation_pairs,
            model,
            settings,
        ]
    )


def settings_of_judging(config: Config, model: ModelName) -> str:
    """Everything that a judge of places depends on, as JSON."""
    return json.dumps(
        [settings_of_training(config, model), config.masks.view_classifier.model_dump(mode="json")]
    )


def check_masks(config: Config) -> None:
    """Raise UserError for what can be told before any job: a joint, a room or a piece of furniture that is not there."""
    first_of_arm(robot_of_masks(config))
    settings = config.masks.map
    scene = scene_of(config.apartment, settings.scene)
    rooms, fixtures = (
        [area.name for area in scene.areas],
        {fixture.name for fixture in scene.fixtures},
    )
    if settings.cramped_room not in rooms:
        raise ConfigError(
            f"masks.map.cramped_room: {settings.scene!r} has no room {settings.cramped_room!r}; choose one of {', '.join(rooms)}"
        )
    for name in settings.low_furniture:
        if name not in fixtures:
            raise ConfigError(
                f"masks.map.low_furniture: {settings.scene!r} has no furniture {name!r}; name furniture of its floor plan"
            )


def _files(config: Config, scenes: Sequence[str]) -> list[tuple[str, ...]]:
    """Contents of the files that describe the robot and scenes."""
    settings = config.apartment
    robot = contents(settings.robots[config.masks.robot].description, "robot")
    return [robot, *(contents(settings.scenes[scene].file, "scene") for scene in scenes)]


def _recipe(settings: MaskModelConfig | ViewClassifierConfig) -> TrainingSettings:
    from ...change_detection.training.trainer import TrainingSettings  # imports torch

    return TrainingSettings(
        settings.samples, settings.batch_size, settings.learning_rate, settings.weight_decay
    )
