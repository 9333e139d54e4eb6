"""The velocity controller of a robot, under which free motion commutes and blocked motion is lost.

A motor that only follows a velocity creeps under gravity. One that follows the position where the
commands add up later catches up on everything it could not do, so even hitting a wall would
commute. This controller integrates the commanded velocities, 240 times a second, to *target*
positions, but keeps each target within a maximum tracking error of the measured position: what is
blocked for longer is lost. The motors follow the velocity of the target plus a proportional
correction of the tracking error. Commanded velocities change linearly over each action, so motors
can follow.

The base has three axes, x, y and heading, whose targets follow the exact arcs of a differential
drive; otherwise they are controlled like joints. In free space the orders of a sequence thus end
equal up to rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....compiled import njit
from .robot import CONTROL_STEP, Robot

SUBSTEPS = 24
"""Physics steps per action, 240 per second (iGibson's environments: 1/10 s and 1/240 s)."""
DT = CONTROL_STEP / SUBSTEPS
"""Duration of a physics step, seconds."""

POSITION_GAIN = 0.3
"""Fraction of the tracking error corrected per substep; measured: 1 rings, 0.05 sags."""
MAX_BASE_ERROR = 0.03
"""Maximum tracking error of x and y, metres; measured: at full speed the base lags by less."""
MAX_HEADING_ERROR = 0.05
"""Maximum tracking error of the heading, rad; measured as for MAX_BASE_ERROR."""
MAX_REVOLUTE_ERROR = 0.02
"""Maximum tracking error of revolute joints, rad; measured: at full speed joints lag by less."""
MAX_PRISMATIC_ERROR = 0.005
"""Maximum tracking error of prismatic joints, metres; measured as for MAX_REVOLUTE_ERROR, and
chosen so small because one action moves Fetch's torso by 0.01 m."""
OVERSPEED = 1.5
"""Maximum velocity of a motor, in units of the commanded maximum; chosen: catches up within the
tracking error, and does not throw objects."""


class ControllerParameters(NamedTuple):
    """The constants of a robot's controller.

    An axis is a motor: x, y and heading of the base, if it has a drive, and then the joints.

    Attributes
    ----------
    dof_of_axis : int64 (axes,)
        Degree of freedom that commands the axis; -1 for those of the base.
    ratio : float64 (axes,)
        How far the axis moves for each unit that its degree of freedom moves.
    dof_velocity : float64 (dofs,)
        Velocity that an action of 1 commands, rad/s or m/s.
    wheels : int64 (2,)
        Degrees of freedom of the right and the left wheel; -1 without a drive.
    wheel_radius, track : float
        Metres.
    low, high : float64 (axes,)
        Limits, rad or m.
    max_tracking_error : float64 (axes,)
        Maximum distance of the target from the measured position, rad or m.
    max_velocity : float64 (axes,)
        Maximum velocity target of the motor, rad/s or m/s.
    """

    dof_of_axis: np.ndarray
    ratio: np.ndarray
    dof_velocity: np.ndarray
    wheels: np.ndarray
    wheel_radius: float
    track: float
    low: np.ndarray
    high: np.ndarray
    max_tracking_error: np.ndarray
    max_velocity: np.ndarray


class ControllerState(NamedTuple):
    """The variables of a robot's controller.

    Attributes
    ----------
    target : float64 (axes,)
        Target position of each axis, rad or m.
    previous_command, command : float64 (dofs,)
        Commanded velocities at the beginning and the end of the current action, rad/s or m/s.
    """

    target: np.ndarray
    previous_command: np.ndarray
    command: np.ndarray

    def copy(self) -> ControllerState:
        """Return a deep copy."""
        return ControllerState(*(array.copy() for array in self))

    def assign(self, other: ControllerState) -> None:
        """Copy the values of another state into this one."""
        for array, value in zip(self, other, strict=True):
            array[:] = value


def make_controller(robot: Robot) -> tuple[ControllerParameters, np.ndarray]:
    """Return the controller of a robot and the maximum force of each motor.

    Returns
    -------
    parameters : ControllerParameters
    forces : float64 (axes,)
        N or Nm.
    """
    description, dofs = robot.description, robot.description.dofs
    drive = description.drive
    dof_of_joint, ratio_of_joint = robot.dof_of_joint, robot.ratio_of_joint
    dof_velocity = np.array([dof.velocity for dof in dofs])
    wheels = [dof_of_joint[name] for name in robot.wheels]
    dof_of_axis, max_error, max_velocity, forces = [], [], [], []
    ratio = [1.0] * (3 if drive is not None else 0) + [
        ratio_of_joint[joint.name] for joint in robot.joints
    ]
    limits = robot.limits
    if drive is not None:
        speed = max(dof_velocity[k] for k in wheels) * robot.wheel_radius
        dof_of_axis = [-1] * 3
        max_error = [MAX_BASE_ERROR, MAX_BASE_ERROR, MAX_HEADING_ERROR]
        max_velocity = [OVERSPEED * speed, OVERSPEED * speed, OVERSPEED * 2 * speed / robot.track]
        forces = [drive.force, drive.force, drive.torque]
        limits = np.concatenate([np.tile((-math.inf, math.inf), (3, 1)), limits])
    for joint in robot.joints:
        dof, prismatic = dofs[dof_of_joint[joint.name]], joint.kind == "prismatic"
        default_force = description.lift_force if prismatic else description.arm_force
        dof_of_axis.append(dof_of_joint[joint.name])
        max_error.append(MAX_PRISMATIC_ERROR if prismatic else MAX_REVOLUTE_ERROR)
        max_velocity.append(OVERSPEED * dof.velocity * abs(ratio_of_joint[joint.name]))
        forces.append(dof.force or default_force)
    parameters = ControllerParameters(
        dof_of_axis=np.array(dof_of_axis, np.int64),
        ratio=np.array(ratio, np.float64),
        dof_velocity=dof_velocity,
        wheels=np.array(wheels or [-1, -1], np.int64),
        wheel_radius=robot.wheel_radius if drive else 0.0,
        track=robot.track if drive else 1.0,
        low=np.ascontiguousarray(limits[:, 0]),
        high=np.ascontiguousarray(limits[:, 1]),
        max_tracking_error=np.array(max_error),
        max_velocity=np.array(max_velocity),
    )
    return parameters, np.array(forces)


def hold_still(parameters: ControllerParameters, measured: np.ndarray) -> ControllerState:
    """Return the state that keeps the axes at rest at `measured`, float64 (axes,)."""
    n = len(parameters.dof_velocity)
    return ControllerState(np.array(measured, np.float64), np.zeros(n), np.zeros(n))


@njit()
def start_action(
    parameters: ControllerParameters, state: ControllerState, action: np.ndarray
) -> None:
    """Set the command to an action, float64 (dofs,), clipped to [-1, 1]."""
    for k in range(len(parameters.dof_velocity)):
        state.previous_command[k] = state.command[k]
        state.command[k] = min(max(action[k], -1.0), 1.0) * parameters.dof_velocity[k]


@njit()
def advance(
    parameters: ControllerParameters,
    state: ControllerState,
    substep: int,
    measured: np.ndarray,
    velocity_target: np.ndarray,
) -> bool:
    """Advance the targets by one substep and compute what the motors do.

    Parameters
    ----------
    parameters : ControllerParameters
    state : ControllerState
        Updated in place.
    substep : int
        Number of the substep in the current action, from 0.
    measured : float64 (axes,)
        Measured positions, rad or m.
    velocity_target : float64 (axes,)
        Output: the velocities that the motors are to follow, rad/s or m/s.

    Returns
    -------
    bool
        Whether a limit stops an axis that is commanded beyond it.
    """
    ramp, at_limit = (substep + 0.5) / SUBSTEPS, False
    speed, turn_rate = 0.0, 0.0
    if parameters.wheels[0] >= 0:
        right = _ramp_velocity(state, parameters.wheels[0], ramp)
        left = _ramp_velocity(state, parameters.wheels[1], ramp)
        speed = parameters.wheel_radius * (right + left) / 2
        turn_rate = parameters.wheel_radius * (right - left) / parameters.track
    for i in range(len(parameters.dof_of_axis)):
        max_error, max_velocity = parameters.max_tracking_error[i], parameters.max_velocity[i]
        # A target that had to wait continues from where it waited: what is blocked is lost.
        start = min(max(state.target[i], measured[i] - max_error), measured[i] + max_error)
        if parameters.dof_of_axis[i] >= 0:
            step = _ramp_velocity(state, parameters.dof_of_axis[i], ramp) * DT * parameters.ratio[i]
        else:
            step = _arc(i, speed * DT, turn_rate * DT, state.target[2] if i < 2 else 0.0)
        low, high = parameters.low[i], parameters.high[i]
        end = start + step
        if end > high or end < low:
            at_limit = at_limit or (step > 0 and end > high) or (step < 0 and end < low)
            end = min(max(end, low), high)
        velocity = (end - start + POSITION_GAIN * (start - measured[i])) / DT
        velocity_target[i] = min(max(velocity, -max_velocity), max_velocity)
        state.target[i] = end
    return at_limit


@njit()
def _ramp_velocity(state, dof, ramp):
    """Return the commanded velocity after a fraction `ramp` of the current action."""
    previous = state.previous_command[dof]
    return previous + ramp * (state.command[dof] - previous)


@njit()
def _arc(axis, forward, turn, heading):
    """Return the motion along x (0), y (1) or heading (2) on an arc of length `forward`.

    The arc turns the base by `turn`, rad, from `heading`.
    """
    if axis == 2:
        return turn
    half = turn / 2
    chord = forward * (math.sin(half) / half if abs(half) > 1e-4 else 1 - half * half / 6)
    return chord * (math.cos(heading + half) if axis == 0 else math.sin(heading + half))
