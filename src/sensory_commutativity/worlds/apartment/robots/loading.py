"""Reading a robot's description and its URDF, and checking them against each other."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ....errors import ConfigError
from ....storage.settings_errors import check_json_value, explain
from ....storage.yamlfile import read_yaml
from ..files import FileError, locate
from .checks import find_problems
from .description import RobotDescription
from .robot import Robot
from .urdf import RobotError
from .urdf_reader import read_urdf


def load_robot(file: str | Path) -> Robot:
    """Read a robot's description and its URDF.

    Raises
    ------
    RobotError
        In one line: the file, the key, and how to correct it.
    """
    path = Path(file)
    settings = read_yaml(path, RobotError, "a robot's description, e.g. config/robots/fetch.yaml")
    return parse_robot(settings, path.parent, str(path))


def parse_robot(settings: Any, folder: Path, where: str) -> Robot:
    """Build a robot from the contents of its YAML file.

    Parameters
    ----------
    settings : object
        What the file contains.
    folder : Path
        Paths in `settings` are relative to it.
    where : str
        Start of error messages.

    Raises
    ------
    RobotError
    """
    if not isinstance(settings, dict):
        raise RobotError(
            f"{where}: expected a mapping of keys to values, got {type(settings).__name__}; "
            "see config/robots/fetch.yaml"
        )
    try:
        check_json_value(settings, "robot")
        description = RobotDescription.model_validate_json(json.dumps(settings))
    except ConfigError as error:
        raise RobotError(f"{where}: {error}") from None
    except ValidationError as error:
        message = explain(error, RobotDescription).removeprefix("config: ")
        raise RobotError(f"{where}: {message}") from None
    try:
        path = locate(description.urdf, folder)
    except FileError as error:
        raise RobotError(
            f"{where}: urdf: there is no file {description.urdf!r}: it {error}; "
            f"give a path relative to {folder}, or package://NAME/PATH"
        ) from None
    return _check(Robot(description, read_urdf(path)), where)


def set_fixed_joints(robot: Robot, fixed: dict[str, float], where: str) -> Robot:
    """Return the robot with other positions of joints outside its degrees of freedom.

    Parameters
    ----------
    robot : Robot
    fixed : dict
        Name of a joint -> position, rad or m.
    where : str
        Start of error messages.

    Raises
    ------
    RobotError
    """
    description = robot.description.model_copy(update={"fixed": robot.description.fixed | fixed})
    return _check(Robot(description, robot.urdf), where)


def _check(robot: Robot, where: str) -> Robot:
    problem = next(find_problems(robot), None)
    if problem is not None:
        raise RobotError(f"{where}: {problem}")
    return robot
