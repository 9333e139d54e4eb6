"""A robot's description: which URDF it is, which joints are its degrees of freedom, where its camera sits, how it may start.

The description is a YAML file (:class:`RobotDescription` lists its keys; ``config/robots/`` holds two). Together with the URDF that it names it
makes a :class:`Robot`. All that does not fit together is told at once, in one line.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from ....errors import ConfigError
from ....scp.world import Dof
from ....storage.settings import Name, Section
from ....storage.settings_errors import explain, refuse_what_json_has_not
from ....storage.yamlfile import read_yaml
from .urdf import Joint, RobotError, Urdf, find_file, read_urdf

CONTROL_STEP = 0.1
"""Seconds that an action lasts (iGibson's environments act at 10 Hz: env_base.py, action_timestep 1/10)."""

Triple = Annotated[list[float], Field(min_length=3, max_length=3)]
Range = Annotated[list[float], Field(min_length=2, max_length=2)]


class DofDescription(Section):
    """A degree of freedom: one dimension of the action space."""

    name: Name = Field(description="What tables and figures call it.")
    joints: list[str] = Field(
        min_length=1, description="Joints of the URDF that move together, all by the same amount."
    )
    unit: Literal["rad", "m"] = Field(
        description="rad for joints that turn, m for joints that slide; must fit the URDF."
    )
    velocity: float = Field(
        gt=0, description="What an action of 1 commands, in the unit per second."
    )
    group: Name = Field(
        description="Kind of joint, for averages over several: wheel, torso, shoulder, elbow, wrist, ..."
    )
    force: float | None = Field(
        None,
        gt=0,
        description="Most that its motors can do, Nm or N; without it arm_force or, for sliding joints, lift_force.",
    )


class DriveDescription(Section):
    """Two wheels, each driven for itself, that move the base: a differential drive. A positive action turns a wheel forwards."""

    right_wheel: str = Field(description="Joint of the wheel on the right (at negative y).")
    left_wheel: str = Field(description="Joint of the wheel on the left.")
    wheel_radius: float = Field(gt=0, description="Metres.")
    track: float = Field(gt=0, description="Metres from wheel to wheel.")
    force: float = Field(
        1500.0, gt=0, description="Most that the base can push with, N."
    )  # apartment-control: follows a ramp of 1 m/s with 115 kg
    torque: float = Field(
        700.0, gt=0, description="Most that the base can turn with, Nm."
    )  # the same, for 6 rad/s


class CameraDescription(Section):
    """Where the robot sees from. It looks along its own x axis, y is left, z is up."""

    link: str = Field(description="Link of the URDF that carries it.")
    position: Triple = Field(description="Metres, in the link's frame.")
    rotation: Triple = Field(
        [0.0, 0.0, 0.0],
        description="Roll, pitch and yaw in the link's frame, rad; a positive pitch looks down.",
    )
    field_of_view: float = Field(
        90.0,
        ge=5,
        le=150,
        description="Vertical, degrees; the apartment's configuration may ask for others.",
    )


class RobotDescription(Section):
    """A robot. Its axes are those of ROS: x forward, y left, z up."""

    name: Name
    about: str = Field(
        "", description="Where the model comes from, its licence, what is approximate."
    )
    urdf: str = Field(
        min_length=1,
        description="URDF: a path relative to this file, or package://NAME/PATH of an installed Python package.",
    )
    dofs: list[DofDescription] = Field(
        min_length=1, description="Degrees of freedom, in the order of the action vector."
    )
    drive: DriveDescription | None = Field(
        None, description="How wheels move the base; without it the base is fixed to the floor."
    )
    camera: CameraDescription
    height: float | None = Field(
        None,
        description="Metres of the root link above the floor; without it as high as puts the wheels on it, or 0.",
    )
    fixed: dict[str, float] = Field(
        default_factory=dict,
        description="Position of joints that are no degree of freedom; 0 if not listed.",
    )
    start: dict[str, Range] = Field(
        default_factory=dict,
        description="Where the joints of degrees of freedom start: lowest, highest; 0 if not listed.",
    )
    arm_force: float = Field(
        1000.0, gt=0, description="Most that the motors of turning joints can do, Nm."
    )  # apartment-control: less lags behind
    lift_force: float = Field(
        5000.0, gt=0, description="Most that the motors of sliding joints can do, N."
    )  # the same; Fetch's torso lifts 40 kg
    passing: list[Annotated[list[str], Field(min_length=2, max_length=2)]] = Field(
        default_factory=list,
        description="Pairs of links that pass through each other, besides those that share a joint.",
    )
    hierarchy: list[Name] = Field(
        default_factory=list,
        description="Groups of degrees of freedom from the lowest SCP that is expected to the highest; tested if at least two.",
    )
    faces_per_mesh: int = Field(
        160, ge=4, le=100_000, description="Triangles that the camera draws of each mesh, at most."
    )


@dataclass(frozen=True)
class Robot:
    """A description and the URDF that it names, checked against each other."""

    description: RobotDescription
    urdf: Urdf

    @cached_property
    def wheels(self) -> tuple[str, ...]:
        """Joints of the wheels, right and left; empty without a drive."""
        drive = self.description.drive
        return (drive.right_wheel, drive.left_wheel) if drive else ()

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The joints that move and are no wheel, outwards from the root: wherever this package has an array of joints, it is in this order."""
        driven = {name for dof in self.description.dofs for name in dof.joints} - set(self.wheels)
        found, waiting = [], [self.urdf.root]
        while waiting:
            below = self.urdf.joints_below(waiting.pop())
            found += [joint for joint in below if joint.name in driven]
            waiting += [joint.child for joint in reversed(below)]
        return tuple(found)

    @cached_property
    def hierarchy(self) -> dict[str, list[str]]:
        """Groups of degrees of freedom, from the lowest SCP that is expected to the highest, and the names in each."""
        return {
            group: [dof.name for dof in self.description.dofs if dof.group == group]
            for group in self.description.hierarchy
        }

    @cached_property
    def start_ranges(self) -> np.ndarray:
        """Lowest and highest start position of each of `joints`: float64 (n, 2), rad or m."""
        start = self.description.start
        return np.array(
            [start.get(joint.name, (0.0, 0.0)) for joint in self.joints], np.float64
        ).reshape(-1, 2)

    @cached_property
    def limits(self) -> np.ndarray:
        """Lowest and highest position of each of `joints`: float64 (n, 2), rad or m; infinite where nothing stops it."""
        return np.array([(joint.lower, joint.upper) for joint in self.joints], np.float64).reshape(
            -1, 2
        )

    @cached_property
    def dofs(self) -> tuple[Dof, ...]:
        """The degrees of freedom as experiments know them; ranges are relative to the middle of the start range."""
        return tuple(self._dof(dof) for dof in self.description.dofs)

    @cached_property
    def height(self) -> float:
        """Metres of the root link above the floor."""
        if self.description.height is not None:
            return self.description.height
        drive = self.description.drive
        return (
            drive.wheel_radius - self._from_root(self.urdf.joints[drive.right_wheel])[2, 3]
            if drive
            else 0.0
        )

    def draw_joints(self, rng: np.random.Generator) -> np.ndarray:
        """Joint positions drawn uniformly from the start ranges: float64 (n,), rad or m."""
        return rng.uniform(self.start_ranges[:, 0], self.start_ranges[:, 1])

    def _dof(self, dof: DofDescription) -> Dof:
        low, high = -math.inf, math.inf
        for joint, start in zip(self.joints, self.start_ranges, strict=True):
            if joint.name in dof.joints:
                low, high = (
                    max(low, joint.lower - start.mean()),
                    min(high, joint.upper - start.mean()),
                )
        return Dof(dof.name, dof.unit, dof.velocity * CONTROL_STEP, float(low), float(high))

    def _from_root(self, joint: Joint) -> np.ndarray:
        """Where a joint's child is when all joints are at zero, seen from the root: float64 (4, 4)."""
        above = next(
            (other for other in self.urdf.joints.values() if other.child == joint.parent), None
        )
        return joint.frame if above is None else self._from_root(above) @ joint.frame


def load_robot(file: str | Path) -> Robot:
    """Read a robot's description and its URDF. Raises RobotError with one line that names the file, the key and the remedy."""
    path = Path(file)
    settings = read_yaml(path, RobotError, "a robot's description, e.g. config/robots/fetch.yaml")
    return robot_from(settings, path.parent, str(path))


def robot_from(settings: Any, folder: Path, where: str) -> Robot:
    """A robot from what its YAML file holds; `folder` is what its paths are relative to, `where` what messages name. Raises RobotError."""
    if not isinstance(settings, dict):
        raise RobotError(
            f"{where}: expected a mapping of keys to values, got {type(settings).__name__}; see config/robots/fetch.yaml"
        )
    try:
        refuse_what_json_has_not(settings, "robot")
        description = RobotDescription.model_validate_json(json.dumps(settings))
    except ConfigError as error:
        raise RobotError(f"{where}: {error}") from None
    except ValidationError as error:
        raise RobotError(
            f"{where}: {explain(error, RobotDescription).removeprefix('config: ')}"
        ) from None
    path = find_file(description.urdf, folder)
    if path is None:
        raise RobotError(
            f"{where}: urdf: there is no file {description.urdf!r}; give a path relative to {folder}, or package://NAME/PATH"
        )
    robot = Robot(description, read_urdf(path))
    problem = next(_problems(robot), None)
    if problem:
        raise RobotError(f"{where}: {problem}")
    return robot


def with_fixed(robot: Robot, fixed: dict[str, float], where: str) -> Robot:
    """The robot with other positions of joints that are no degree of freedom; `where` is what messages name. Raises RobotError."""
    description = robot.description.model_copy(update={"fixed": robot.description.fixed | fixed})
    changed = Robot(description, robot.urdf)
    problem = next(_problems(changed), None)
    if problem:
        raise RobotError(f"{where}: {problem}")
    return changed


def _problems(robot: Robot):
    """What does not fit together in a description and its URDF, each with its remedy."""
    description, links, joints = robot.description, robot.urdf.links, robot.urdf.joints
    driven: dict[str, str] = {}
    for dof in description.dofs:
        if [other.name for other in description.dofs].count(dof.name) > 1:
            yield f"dofs: two are called {dof.name!r}; rename one"
        for name in dof.joints:
            if name not in joints:
                yield f"dofs: {dof.name!r} names the joint {name!r}, which {robot.urdf.path.name} has not; it has {_movable(joints)}"
                continue
            if name in driven:
                yield f"dofs: the joint {name!r} is moved by {driven[name]!r} and by {dof.name!r}; leave it out of one"
            driven[name] = dof.name
            kind = joints[name].kind
            if kind == "fixed" or joints[name].lower == joints[name].upper:
                yield f"dofs: {dof.name!r} names the joint {name!r}, which cannot move; choose one of {_movable(joints)}"
            if dof.unit != ("m" if kind == "prismatic" else "rad"):
                yield f"dofs: {dof.name!r} has the unit {dof.unit}, but its joint {name!r} is {kind}; write {'m' if kind == 'prismatic' else 'rad'}"
    for key, name in zip(("right_wheel", "left_wheel"), robot.wheels, strict=False):
        if name not in driven:
            yield f"drive.{key}: the joint {name!r} belongs to no degree of freedom; name the joint of a wheel that is listed under dofs"
    if len(set(robot.wheels)) == 1:
        yield f"drive: both wheels are the joint {robot.wheels[0]!r}; name two"
    for dof in description.dofs:
        if set(dof.joints) & set(robot.wheels) and len(dof.joints) > 1:
            yield f"dofs: {dof.name!r} moves a wheel and another joint; give each wheel a degree of freedom of its own"
    groups = sorted({dof.group for dof in description.dofs})
    for group in description.hierarchy:
        if group not in groups:
            yield f"hierarchy: no degree of freedom is of the group {group!r}; the groups are {', '.join(groups)}"
        elif description.hierarchy.count(group) > 1:
            yield f"hierarchy: the group {group!r} is there twice; remove one"
    if description.camera.link not in links:
        yield f"camera.link: {robot.urdf.path.name} has no link {description.camera.link!r}; it has {', '.join(links)}"
    for a, b in description.passing:
        for name in (a, b):
            if name not in links:
                yield f"passing: {robot.urdf.path.name} has no link {name!r}; it has {', '.join(links)}"
    yield from _position_problems(robot, driven)


def _position_problems(robot: Robot, driven: dict[str, str]):
    """The same for positions of joints."""
    description, joints = robot.description, robot.urdf.joints
    for name, position in description.fixed.items():
        if name not in joints or joints[name].kind == "fixed":
            yield f"fixed: {robot.urdf.path.name} has no joint {name!r} that could move; it has {_movable(joints)}"
        elif name in driven:
            yield f"fixed: the joint {name!r} is moved by {driven[name]!r}; give it a range under start instead"
        elif not joints[name].lower <= position <= joints[name].upper:
            yield f"fixed: {name!r} cannot be at {position:g}; it moves from {joints[name].lower:g} to {joints[name].upper:g}"
    movable = [joint.name for joint in robot.joints]
    for name, (low, high) in description.start.items():
        if name not in movable:
            yield f"start: {name!r} is no joint of a degree of freedom (wheels have no start); choose among {', '.join(movable)}"
        elif low > high:
            yield f"start: {name!r} has the range {low:g} to {high:g}; write the lower number first"
    for joint, (low, high) in zip(robot.joints, robot.start_ranges, strict=True):
        if low < joint.lower or high > joint.upper:
            listed = "" if joint.name in description.start else " (not listed, so it starts at 0)"
            yield (
                f"start: {joint.name!r} would start from {low:g} to {high:g}{listed}, beyond its limits {joint.lower:g} to {joint.upper:g}; "
                "set a range within them"
            )


def _movable(joints: dict[str, Joint]) -> str:
    return ", ".join(name for name, joint in joints.items() if joint.kind != "fixed")
