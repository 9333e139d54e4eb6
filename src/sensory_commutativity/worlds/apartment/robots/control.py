"""The control under which a motion that touches nothing commutes to rounding, and one that is blocked is lost.

A motor that is only told a velocity creeps under gravity; one that is told the position where the commands add up to catches up later on whatever it
could not do, so that hitting a wall would commute. Here, 240 times a second, the commanded velocities (rising linearly over each action, so that the
motors can follow) are added up to *targets*, and a target never runs further than a *slack* ahead of what is measured: what is blocked for longer is
lost. Motors are told the velocity of the target plus a part of its distance. The base has three targets, x, y and heading, that run along the exact
arcs of a differential drive, and is else treated as a joint is.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....compiled import njit
from .robot import CONTROL_STEP, Robot

SUBSTEPS = 24
"""Steps of the physics in an action, 240 per second (iGibson's environments: 1/10 s and 1/240 s)."""
DT = CONTROL_STEP / SUBSTEPS

GAIN = 0.3  # of the distance to the target, per substep; measured: 1 rings, 0.05 sags
BASE_SLACK, HEADING_SLACK = (
    0.03,
    0.05,
)  # m, rad; measured: the base lags behind full commands by less
TURN_SLACK, SLIDE_SLACK = (
    0.02,
    0.005,
)  # rad, m; measured: the same of joints; chosen so small for slides because an action moves Fetch's torso by 0.01 m
FASTEST = 1.5  # times the commanded velocity limit is what a motor is told at most; chosen: catches up within the slack, and does not throw things


class Law(NamedTuple):
    """What the control of a robot is made of. Axes are x, y, heading of the base, if it has a drive, and then the joints.

    Attributes
    ----------
    of_axis : int64 (n,)
        The degree of freedom whose velocity an axis has; -1 for those of the base.
    velocity : float64 (dofs,)
        What an action of 1 commands, rad/s or m/s.
    wheels : int64 (2,)
        The degrees of freedom of the right and the left wheel; -1 without a drive.
    wheel_radius, track : float
        Metres.
    low, high, slack, most : float64 (n,)
        Limits of an axis, its slack, the fastest that its motor is told.
    """

    of_axis: np.ndarray
    velocity: np.ndarray
    wheels: np.ndarray
    wheel_radius: float
    track: float
    low: np.ndarray
    high: np.ndarray
    slack: np.ndarray
    most: np.ndarray


class Control(NamedTuple):
    """Where the control has got to.

    Attributes
    ----------
    target : float64 (n,)
        Where each axis should be.
    before, command : float64 (dofs,)
        Velocities at the beginning and the end of the present action.
    """

    target: np.ndarray
    before: np.ndarray
    command: np.ndarray

    def copy(self) -> Control:
        """A copy that shares nothing."""
        return Control(*(array.copy() for array in self))

    def set(self, other: Control) -> None:
        """Take over the values of another."""
        for own, value in zip(self, other, strict=True):
            own[:] = value


def law_of(robot: Robot) -> tuple[Law, np.ndarray]:
    """The control of a robot, and the most that the motor of each axis can do: float64 (n,), N or Nm."""
    description, dofs = robot.description, robot.description.dofs
    drive, moved_by = (
        description.drive,
        {name: k for k, dof in enumerate(dofs) for name in dof.joints},
    )
    velocity = np.array([dof.velocity for dof in dofs])
    axes, slack, most, force = [], [], [], []
    limits = robot.limits
    if drive is not None:
        speed = max(velocity[moved_by[name]] for name in robot.wheels) * drive.wheel_radius
        axes, slack, force = (
            [-1] * 3,
            [BASE_SLACK, BASE_SLACK, HEADING_SLACK],
            [drive.force, drive.force, drive.torque],
        )
        most = [FASTEST * speed, FASTEST * speed, FASTEST * 2 * speed / drive.track]
        limits = np.concatenate([np.tile((-math.inf, math.inf), (3, 1)), limits])
    for joint in robot.joints:
        dof, slides = dofs[moved_by[joint.name]], joint.kind == "prismatic"
        axes.append(moved_by[joint.name])
        slack.append(SLIDE_SLACK if slides else TURN_SLACK)
        most.append(FASTEST * dof.velocity)
        force.append(dof.force or (description.lift_force if slides else description.arm_force))
    law = Law(
        np.array(axes, np.int64), velocity, np.array([moved_by[name] for name in robot.wheels] or [-1, -1], np.int64),
        drive.wheel_radius if drive else 0.0, drive.track if drive else 1.0,
        np.ascontiguousarray(limits[:, 0]), np.ascontiguousarray(limits[:, 1]), np.array(slack), np.array(most),
    )  # fmt: skip
    return law, np.array(force)


def at_rest(law: Law, measured: np.ndarray) -> Control:
    """Control that stands still where the axes are: `measured`, float64 (n,)."""
    return Control(
        np.array(measured, np.float64), np.zeros(len(law.velocity)), np.zeros(len(law.velocity))
    )


@njit()
def begin(law: Law, control: Control, action: np.ndarray) -> None:
    """A new action, float64 (dofs,), is played from now on; clipped to [-1, 1]."""
    for k in range(len(law.velocity)):
        control.before[k] = control.command[k]
        control.command[k] = min(max(action[k], -1.0), 1.0) * law.velocity[k]


@njit()
def advance(
    law: Law, control: Control, substep: int, measured: np.ndarray, told: np.ndarray
) -> bool:
    """Run the targets on by one substep of the present action and tell the motors.

    Parameters
    ----------
    substep : int
        Which of the action's, from 0.
    measured : float64 (n,)
        Where the axes are.
    told : float64 (n,)
        Is filled with the velocities that the motors are told.

    Returns
    -------
    bool
        Whether a limit keeps a joint from going where it is commanded.
    """
    risen, at_limit = (substep + 0.5) / SUBSTEPS, False
    speed, turn = 0.0, 0.0
    if law.wheels[0] >= 0:
        right, left = (
            _velocity(control, law.wheels[0], risen),
            _velocity(control, law.wheels[1], risen),
        )
        speed = law.wheel_radius * (right + left) / 2
        turn = law.wheel_radius * (right - left) / law.track
    for i in range(len(law.of_axis)):
        # A target that was held back runs on from where it is held: what is blocked is lost.
        start = min(max(control.target[i], measured[i] - law.slack[i]), measured[i] + law.slack[i])
        if law.of_axis[i] >= 0:
            step = _velocity(control, law.of_axis[i], risen) * DT
        else:
            step = _arc(i, speed * DT, turn * DT, control.target[2] if i < 2 else 0.0)
        end = start + step
        if end > law.high[i] or end < law.low[i]:
            at_limit = (
                at_limit or (step > 0 and end > law.high[i]) or (step < 0 and end < law.low[i])
            )
            end = min(max(end, law.low[i]), law.high[i])
        told[i] = min(
            max((end - start + GAIN * (start - measured[i])) / DT, -law.most[i]), law.most[i]
        )
        control.target[i] = end
    return at_limit


@njit()
def _velocity(control, dof, risen):
    return control.before[dof] + risen * (control.command[dof] - control.before[dof])


@njit()
def _arc(axis, forward, turn, heading):
    """How far a base moves along x (0), y (1) or its heading (2) on an arc of the length `forward` that turns it by `turn`."""
    if axis == 2:
        return turn
    half = turn / 2
    chord = forward * (math.sin(half) / half if abs(half) > 1e-4 else 1 - half * half / 6)
    return chord * (math.cos(heading + half) if axis == 0 else math.sin(heading + half))
