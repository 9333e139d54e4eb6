"""Robots of the gallery in its scenes, as worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...errors import ConfigError
from ..apartment.builders import contents
from ..config import Config
from .config import GalleryConfig

if TYPE_CHECKING:
    from ...worlds.apartment.robots.robot import Robot
    from ...worlds.apartment.world import ApartmentWorld


def gallery(config: Config) -> GalleryConfig:
    """The section gallery. Raises ConfigError if the configuration has none."""
    if config.gallery is None:
        raise ConfigError("config: there is no section gallery; merge config/gallery.yaml over it")
    return config.gallery


def runs(config: Config) -> dict[str, tuple[str, str]]:
    """Robot and scene of every run by name, ``ROBOT.SCENE``; none without a section gallery."""
    if config.gallery is None:
        return {}
    return {
        f"{robot}.{scene}": (robot, scene)
        for robot in config.gallery.robots
        for scene in config.gallery.scenes
    }


def load_gallery_robot(config: Config, robot: str) -> Robot:
    """The robot gallery.robots.`robot`. Raises RobotError."""
    from ...worlds.apartment.robots.loading import load_robot

    return load_robot(gallery(config).robots[robot].description)


def build_gallery_world(config: Config, robot: str, scene: str) -> ApartmentWorld:
    """The robot in the scene, both by name."""
    from ...worlds.apartment.rendering.camera import Camera
    from ...worlds.apartment.scenes.empty import empty_floor
    from ...worlds.apartment.scenes.scenefile import load_scene
    from ...worlds.apartment.world import ApartmentWorld  # imports PyBullet

    settings, loaded = gallery(config), load_gallery_robot(config, robot)
    file, size = settings.scenes[scene].file, settings.image_size
    built = empty_floor(scene) if file is None else load_scene(file)
    camera = Camera(size, size, loaded.description.camera.field_of_view)
    return ApartmentWorld(built, loaded, [camera])


def settings_of_run(config: Config, run: str) -> list[object]:
    """Everything that an experiment depends on, including contents of files; JSON values."""
    settings = gallery(config)
    robot, scene = runs(config)[run]
    return [
        config.seed,
        run,
        contents(settings.robots[robot].description, "robot"),
        contents(settings.scenes[scene].file, "scene"),
        settings.sequence_length,
        settings.rest_steps,
        settings.image_size,
    ]


def check_gallery(config: Config) -> None:
    """Check that the robots of the gallery, if there is one, can be loaded; fast, reads no meshes.

    Raises
    ------
    UserError
        With the file, what is wrong, and the remedy.
    """
    for robot in config.gallery.robots if config.gallery is not None else ():
        load_gallery_robot(config, robot)
