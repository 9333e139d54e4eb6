"""What the configuration of the apartment names: scenes, worlds, and runs of experiments."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...errors import ConfigError, UserError
from ...seeding import generator, seed_for
from ...storage.hashing import sha256
from ..config import Config
from .config import ApartmentConfig, ApartmentRun

if TYPE_CHECKING:
    from ...perceptual.features import PerceptualFeatures
    from ...worlds.apartment.robots.robot import Robot
    from ...worlds.apartment.scenes.scene import Scene
    from ...worlds.apartment.world import ApartmentWorld

CHECKED_SITUATIONS = 3
"""Start situations that are drawn of every robot, scene and start to check a configuration.
Chosen: a second each."""


def experiment_runs(config: Config) -> dict[str, ApartmentRun]:
    """All runs of SC-experiments by name, ``ROBOT.SCENE.START.LENGTH``."""
    return {
        f"{run.robot}.{run.scene}.{run.start}.{run.length}": run for run in config.apartment.runs()
    }


def build_scene(settings: ApartmentConfig, scene: str) -> Scene:
    """The scene apartment.scenes.`scene`, an empty floor if it has no file. Raises SceneError."""
    from ...worlds.apartment.scenes.empty import empty_floor
    from ...worlds.apartment.scenes.scenefile import load_scene

    file = settings.scenes[scene].file
    return empty_floor(scene) if file is None else load_scene(file)


def load_named_robot(settings: ApartmentConfig, robot: str) -> Robot:
    """The robot apartment.robots.`robot`. Raises RobotError."""
    from ...worlds.apartment.robots.loading import load_robot

    return load_robot(settings.robots[robot].description)


def count_dofs(settings: ApartmentConfig) -> dict[str, int]:
    """Number of degrees of freedom of every robot that a run names."""
    robots = dict.fromkeys(run.robot for run in settings.runs())
    return {robot: len(load_named_robot(settings, robot).dofs) for robot in robots}


def apartment_world(
    config: Config, robot: str, scene: str, start: str, views: Sequence[float] = ()
) -> ApartmentWorld:
    """The robot in the scene, both by name.

    Parameters
    ----------
    config : Config
    robot, scene : str
        Keys of apartment.robots and apartment.scenes.
    start : str
        ``anywhere`` or ``within-reach``.
    views : sequence of float
        Vertical field of view of each camera, degrees. By default one camera with the first of
        apartment.fields_of_view.
    """
    from ...worlds.apartment.rendering.camera import Camera
    from ...worlds.apartment.world import ApartmentWorld  # imports PyBullet

    settings = config.apartment
    size, within = settings.image_size, settings.reach if start == "within-reach" else None
    cameras = [
        Camera(size, size, float(view), settings.supersampling)
        for view in views or settings.fields_of_view[:1]
    ]
    return ApartmentWorld(
        build_scene(settings, scene), load_named_robot(settings, robot), cameras, within
    )


def build_run_world(config: Config, run: ApartmentRun) -> ApartmentWorld:
    """The world of a run's experiments, with a camera for each of its fields of view."""
    return apartment_world(config, run.robot, run.scene, run.start, config.apartment.views(run))


def perceptual_features(config: Config) -> PerceptualFeatures:
    """The VGG16 features that images are compared by. Raises WeightsError."""
    from ...perceptual.features import PerceptualFeatures  # imports torch
    from ...perceptual.weights import load_vgg16_weights

    return PerceptualFeatures(load_vgg16_weights(config.apartment.weights))


def start_seed(config: Config, robot: str, scene: str, start: str, i: int) -> int:
    """Seed of everything random in experiment `i` of a run."""
    return seed_for(config.seed, "apartments", robot, scene, start, i)


@cache
def contents(file: str | None, kind: Literal["robot", "scene", "weights"]) -> tuple[str, ...]:
    """SHA-256 of a file and of all files that it refers to; () without a file.

    Results depend on what these files contain, not on their paths.
    """
    if file is None:
        return ()
    paths = [Path(file)]
    if kind == "robot":
        from ...worlds.apartment.robots.loading import load_robot

        paths += load_robot(file).urdf.files
    elif kind == "scene":
        from ...worlds.apartment.scenes.scenefile import list_scene_files

        paths = list_scene_files(file)
    return tuple(sha256(path) for path in paths if path.is_file())


def start_settings(config: Config, robot: str, scene: str, start: str) -> list[object]:
    """Everything that start situations depend on, including contents of files; JSON values."""
    settings = config.apartment
    return [
        config.seed,
        robot,
        scene,
        start,
        contents(settings.robots[robot].description, "robot"),
        contents(settings.scenes[scene].file, "scene"),
        contents(settings.weights, "weights"),
        settings.reach if start == "within-reach" else None,
    ]


def settings_of_run(config: Config, run: ApartmentRun) -> list[object]:
    """Everything that an experiment depends on, including contents of files; JSON values."""
    settings = config.apartment
    return [
        start_settings(config, run.robot, run.scene, run.start),
        run.length,
        settings.views(run),
        settings.rest_steps,
        settings.image_size,
        settings.supersampling,
    ]


def check_apartment(config: Config) -> None:
    """Check that all files exist and can be read; nothing is simulated.

    Raises
    ------
    UserError
        With the file, what is wrong, and the remedy.
    """
    from ...perceptual.weights import WeightsError
    from ...worlds.apartment.robots.checks import check_shapes

    settings = config.apartment
    if settings.weights is not None and not Path(settings.weights).is_file():
        raise WeightsError(
            f"config: apartment.weights: there is no file {settings.weights!r}; "
            "give a file, or null to fetch the weights"
        )
    for robot in settings.robots:
        check_shapes(load_named_robot(settings, robot))
    for run in settings.runs():
        build_scene(settings, run.scene)


def check_ready(config: Config, robot: str, scene: str, start: str) -> dict[str, str]:
    """Check that the VGG16 weights are available and that the robot finds start situations.

    Returns
    -------
    dict
        ``weights``: where the weights come from, and ``sha256``: their hash.

    Raises
    ------
    UserError
        With what is missing, where, and the remedy.
    """
    from ...perceptual.weights import load_vgg16_weights

    weights = load_vgg16_weights(config.apartment.weights)
    try:
        world = apartment_world(config, robot, scene, start)
        for i in range(CHECKED_SITUATIONS):
            world.reset(generator(config.seed, "check", robot, scene, start, i))
    except ConfigError:
        raise
    except UserError as error:
        raise ConfigError(
            f"config: apartment.robots.{robot} in apartment.scenes.{scene}: {error}"
        ) from None
    world.simulation.close()
    return dict(weights=weights.source, sha256=weights.sha256)


def start_poses(config: Config, robot: str, scene: str, start: str, n: int) -> np.ndarray:
    """Poses of the robot at the start of the first `n` experiments of a run.

    Returns
    -------
    float64 (n, 3)
        x and y in metres, heading in rad.
    """
    world, poses = apartment_world(config, robot, scene, start), np.empty((n, 3))
    for i in range(n):
        world.reset(generator(start_seed(config, robot, scene, start, i), "situation"))
        poses[i] = world.simulation.base()
    world.simulation.close()
    return poses


def described_files(config: Config) -> list[list[tuple[str, ...]]]:
    """Contents of all files that describe the robots and scenes of the configuration."""
    settings = config.apartment
    robots = [contents(robot.description, "robot") for robot in settings.robots.values()]
    return [robots, [contents(scene.file, "scene") for scene in settings.scenes.values()]]
