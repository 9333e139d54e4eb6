"""A robot: its description and its URDF, checked against each other."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from ....errors import ConfigError
from ....scp.world import Dof
from ....storage.settings_errors import check_json_value, explain
from ....storage.yamlfile import read_yaml
from .checks import find_problems
from .description import DofDescription, RobotDescription
from .urdf import Joint, RobotError, Urdf, find_file
from .urdf_reader import read_urdf

CONTROL_STEP = 0.1
"""Duration of an action, seconds (iGibson acts at 10 Hz: env_base.py, action_timestep 1/10)."""


@dataclass(frozen=True)
class Robot:
    """A description and the URDF that it names."""

    description: RobotDescription
    urdf: Urdf

    @cached_property
    def wheels(self) -> tuple[str, ...]:
        """Joints of the right and the left wheel; empty without a drive."""
        drive = self.description.drive
        return (drive.right_wheel, drive.left_wheel) if drive else ()

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joints of degrees of freedom except wheels, depth first from the root.

        Every array of joint positions in this package is in this order.
        """
        driven = {name for dof in self.description.dofs for name in dof.joints} - set(self.wheels)
        joints: list[Joint] = []
        stack = [self.urdf.root]
        while stack:
            below = self.urdf.joints_below(stack.pop())
            joints += [joint for joint in below if joint.name in driven]
            stack += [joint.child for joint in reversed(below)]
        return tuple(joints)

    @cached_property
    def hierarchy(self) -> dict[str, list[str]]:
        """Groups from the lowest expected SCP to the highest, with the names of their dofs."""
        return {
            group: [dof.name for dof in self.description.dofs if dof.group == group]
            for group in self.description.hierarchy
        }

    @cached_property
    def start_ranges(self) -> np.ndarray:
        """Lowest and highest start position of each of `joints`: float64 (n, 2), rad or m."""
        start = self.description.start
        ranges = [start.get(joint.name, (0.0, 0.0)) for joint in self.joints]
        return np.array(ranges, np.float64).reshape(-1, 2)

    @cached_property
    def limits(self) -> np.ndarray:
        """Limits of each of `joints`: float64 (n, 2), rad or m; infinite without stops."""
        limits = [(joint.lower, joint.upper) for joint in self.joints]
        return np.array(limits, np.float64).reshape(-1, 2)

    @cached_property
    def dofs(self) -> tuple[Dof, ...]:
        """The degrees of freedom; their ranges are relative to the middle of the start range."""
        return tuple(self._dof(dof) for dof in self.description.dofs)

    @cached_property
    def height(self) -> float:
        """Metres from the floor to the root link."""
        if self.description.height is not None:
            return self.description.height
        drive = self.description.drive
        if drive is None:
            return 0.0
        return drive.wheel_radius - self._pose_in_root(self.urdf.joints[drive.right_wheel])[2, 3]

    def draw_joints(self, rng: np.random.Generator) -> np.ndarray:
        """Draw joint positions uniformly from the start ranges: float64 (n,), rad or m."""
        return rng.uniform(self.start_ranges[:, 0], self.start_ranges[:, 1])

    def clip_joints(self, joints: np.ndarray) -> np.ndarray:
        """Clip joint positions, float64 (n,), to their limits."""
        return np.clip(joints, self.limits[:, 0], self.limits[:, 1])

    def _dof(self, dof: DofDescription) -> Dof:
        low, high = -math.inf, math.inf
        for joint, start in zip(self.joints, self.start_ranges, strict=True):
            if joint.name in dof.joints:
                low = max(low, joint.lower - start.mean())
                high = min(high, joint.upper - start.mean())
        return Dof(dof.name, dof.unit, dof.velocity * CONTROL_STEP, float(low), float(high))

    def _pose_in_root(self, joint: Joint) -> np.ndarray:
        """Return the frame of a joint's child in the root, all joints at zero: float64 (4, 4)."""
        above = next((j for j in self.urdf.joints.values() if j.child == joint.parent), None)
        return joint.frame if above is None else self._pose_in_root(above) @ joint.frame


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
    path = find_file(description.urdf, folder)
    if path is None:
        raise RobotError(
            f"{where}: urdf: there is no file {description.urdf!r}; "
            f"give a path relative to {folder}, or package://NAME/PATH"
        )
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
