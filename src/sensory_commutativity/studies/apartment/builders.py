"""The apartment worlds that the configuration names, and what has to be there before any of them is used."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...errors import ConfigError, UserError
from ...perceptual.features import PerceptualFeatures
from ...perceptual.weights import WeightsError, vgg16_weights
from ...seeding import generator, seed_for
from ...worlds.apartment import geometry
from ...worlds.apartment.robots.robot import load_robot
from ...worlds.apartment.scenes.scene import Area, Fixture, Part, Scene
from ...worlds.apartment.scenes.scenefile import load_scene, scene_files
from ..config import Config
from .config import ApartmentConfig, ApartmentRun

if TYPE_CHECKING:
    from ...worlds.apartment.world import ApartmentWorld

FLOOR_EXTENT = 30.0
"""Metres from the middle of an empty floor to where it ends, for the eye only; chosen: seen from a head at 1.3 m that is less than three pixels of
128 below the horizon."""
START_EXTENT = 2.0
"""Metres: a robot starts so near to the middle of an empty floor; chosen: as in a large room."""


def empty_floor(name: str) -> Scene:
    """A floor that never ends, tiled, so that a robot sees where it is, with nothing on it."""
    mesh = geometry.placed(geometry.box((FLOOR_EXTENT, FLOOR_EXTENT, 0.01)), (0.0, 0.0, -0.01))
    seen = Fixture("floor", (Part(mesh, (0.8, 0.75, 0.7), "checker"),), ())
    return Scene(
        name,
        (seen,),
        (),
        (Area("floor", (-START_EXTENT, START_EXTENT), (-START_EXTENT, START_EXTENT)),),
    )


def scene_of(settings: ApartmentConfig, scene: str) -> Scene:
    """The scene that apartment.scenes.`scene` describes; a scene without a file is an empty floor."""
    file = settings.scenes[scene].file
    return empty_floor(scene) if file is None else load_scene(file)


def apartment_world(
    config: Config, robot: str, scene: str, start: str, views: Sequence[float] = ()
) -> ApartmentWorld:
    """The robot in the scene, both by name, seen through fields of view in degrees; through the first of the configuration's if none are given."""
    from ...worlds.apartment.rendering.camera import Camera
    from ...worlds.apartment.world import (
        ApartmentWorld,  # imports PyBullet, which checking a configuration does not need
    )

    settings = config.apartment
    size, within = settings.image_size, settings.reach if start == "within-reach" else None
    cameras = [
        Camera(size, size, float(view), settings.supersampling)
        for view in views or settings.fields_of_view[:1]
    ]
    return ApartmentWorld(
        scene_of(settings, scene), load_robot(settings.robots[robot].description), cameras, within
    )


def world_of_run(config: Config, run: ApartmentRun) -> ApartmentWorld:
    """The world in which a run's experiments take place."""
    return apartment_world(config, run.robot, run.scene, run.start, config.apartment.views(run))


def perceptual_features(config: Config) -> PerceptualFeatures:
    """What compares pictures. Raises WeightsError where no weights can be had."""
    return PerceptualFeatures(vgg16_weights(config.apartment.weights))


def start_seed(config: Config, robot: str, scene: str, start: str, i: int) -> int:
    """What everything random in experiment `i` of a run follows from."""
    return seed_for(config.seed, "apartments", robot, scene, start, i)


@cache
def contents(file: str | None, kind: Literal["robot", "scene", "weights"]) -> tuple[str, ...]:
    """SHA-256 of every file that a robot's description, a scene's or weights lead to: results depend on what they say, not on where they lie."""
    if file is None:
        return ()
    files = {
        "robot": lambda: [Path(file), *load_robot(file).urdf.files],
        "scene": lambda: scene_files(file),
        "weights": lambda: [Path(file)],
    }[kind]()
    return tuple(hashlib.sha256(path.read_bytes()).hexdigest() for path in files if path.is_file())


def settings_of_run(config: Config, run: ApartmentRun) -> str:
    """Everything in the configuration that a run's experiments depend on, the files that it names among it, as JSON."""
    settings = config.apartment
    keys = {key: getattr(settings, key) for key in ("rest_steps", "image_size", "supersampling")}
    return json.dumps(
        [run, settings_of_start(config, run.robot, run.scene, run.start), settings.views(run), keys]
    )


def check_apartment(config: Config) -> None:
    """Raise UserError for a robot or a scene that cannot be loaded; quick, no simulation is made."""
    settings = config.apartment
    if settings.weights is not None and not Path(settings.weights).is_file():
        raise WeightsError(
            f"config: apartment.weights: there is no file {settings.weights!r}; give a file, or null to fetch the weights"
        )
    for robot in settings.robots.values():
        load_robot(robot.description)
    for run in settings.runs():
        scene_of(settings, run.scene)


TRIED = 3
"""Start situations that are drawn of each run before the long work; chosen: a second each."""


def check_ready(config: Config, robot: str, scene: str, start: str) -> dict[str, str]:
    """What only trying can tell of a run, before the long work: the weights are there, and the robot finds situations to start from.

    Returns
    -------
    dict
        Where the weights are from, and their hash.

    Raises
    ------
    UserError
        With what is missing, where, and the remedy.
    """
    weights = vgg16_weights(config.apartment.weights)
    try:
        world = apartment_world(config, robot, scene, start)
        for i in range(TRIED):
            world.reset(generator(config.seed, "check", robot, scene, start, i))
    except ConfigError:
        raise
    except UserError as error:
        raise ConfigError(
            f"config: apartment.robots.{robot} in apartment.scenes.{scene}: {error}"
        ) from None
    world.simulation.close()
    return dict(weights=weights.source, sha256=weights.sha256)


def settings_of_start(config: Config, robot: str, scene: str, start: str) -> str:
    """Everything in the configuration that start situations depend on, the files that it names among it, as JSON."""
    settings = config.apartment
    files = contents(settings.robots[robot].description, "robot") + contents(
        settings.scenes[scene].file, "scene"
    )
    return json.dumps(
        [
            config.seed,
            robot,
            scene,
            start,
            files,
            contents(settings.weights, "weights"),
            settings.reach if start == "within-reach" else None,
        ]
    )


def start_poses(config: Config, robot: str, scene: str, start: str, n: int) -> np.ndarray:
    """Where the first `n` experiments of a run start: float64 (n, 3), x, y in metres and heading in rad."""
    world, found = apartment_world(config, robot, scene, start), np.empty((n, 3))
    for i in range(n):
        world.reset(generator(start_seed(config, robot, scene, start, i), "situation"))
        found[i] = world.simulation.base()
    world.simulation.close()
    return found
