"""How commands move the agent: compiled loop over actions and sub-steps.

Two things are asked of it (``docs/differences.md``, "Control"). In free space every degree of freedom must commute, to the last bit that the eye
can see; and what is blocked must *lose* its motion, not catch up later, or walls would leave no trace.

Each command moves a *target* (the base's pose, the joints' angles); the bodies are given the velocities that lead to it, exactly those of a rigid
linkage, so that in free motion Chipmunk's solver finds nothing to correct. It hands these velocities to Chipmunk as forces, because Chipmunk
applies forces after it has found contacts and before it solves them. What contacts prevent is lost: a target never runs further than
the slack ahead of what it drives. Commands are rounded to a fine grid on which floating-point sums are exact, whatever their order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled import njit
from .agent import N_LINKS, PARENT
from .eye import look
from .room import path_point

SUBSTEPS = 4  # authors: four sub-steps of 1/4 per action
DT = 1.0 / SUBSTEPS
GRID = 2.0**20  # chosen: sums of commands are exact; 1e-6 of a unit or rad is far below a pixel
SLACK = np.array(
    [0.5, 0.5, 0.02, 0.02, 0.02, 0.02, 0.02]
)  # chosen: units, units, rad...; joints below one pixel (0.0245 rad)
CORRECTION = 0.5  # chosen: a body that lags may be driven this much faster than the agent's top speed to keep up

# places in a world's inner state, float64 (INNER,)
TARGET = slice(0, 7)  # base x, y, heading; four joint angles
HEAD, EYELID, TIME = 7, 8, 9  # rad; factor; steps since the start
INNER = 10


@njit()
def _on_grid(value):
    return math.floor(value * GRID + 0.5) / GRID


@njit()
def _clip(value, low, high):
    return min(max(value, low), high)


@njit()
def _within(value, middle, slack):
    return _clip(value, middle - slack, middle + slack)


class Wiring(NamedTuple):
    """Addresses of a space and its bodies, and the channels through which they are read and written (:mod:`.chipmunk`)."""

    space: int
    links: np.ndarray  # uint64 (5,)
    movers: np.ndarray  # uint64 (m,)
    bodies: np.ndarray  # uint64 (5 + n,): links, then things
    state_channel: int
    state: np.ndarray  # float64: x, y, angle, velocity x, y, angular velocity
    state_cursor: np.ndarray
    force_channel: int
    force: np.ndarray  # float64: x, y, force x, y, torque
    force_cursor: np.ndarray
    velocity_channel: int
    velocity: np.ndarray  # float64: velocity x, y
    velocity_cursor: np.ndarray


class Body(NamedTuple):
    """The agent's body as the control sees it."""

    speeds: np.ndarray  # float64 (8,): what an action of 1 moves in one step, per degree of freedom
    joint_signs: np.ndarray  # float64 (4,)
    joint_low: np.ndarray  # float64 (4,), rad
    joint_high: np.ndarray  # float64 (4,), rad
    eyelid_low: float
    eyelid_high: float
    base_radius: float  # units
    arm_length: float  # units
    mass: np.ndarray  # float64 (5,)
    moment: np.ndarray  # float64 (5,)
    damping: float  # fraction of its velocity that Chipmunk leaves a body in one sub-step


class Paths(NamedTuple):
    """What the `m` moving things follow."""

    corners: np.ndarray  # int64 (m,)
    path: np.ndarray  # float64 (m, corners, 2), units
    phase: np.ndarray  # float64 (m,), units
    speed: float  # units per step


@njit()
def advance(
    step_space,
    read_body,
    write_body,
    wiring,
    body,
    paths,
    scene,
    inner,
    pose,
    actions,
    every_step,
    seen,
):
    """Play `actions` and look.

    Parameters
    ----------
    step_space, read_body, write_body : Chipmunk's functions (:mod:`.chipmunk`)
    wiring : Wiring
    body : Body
    paths : Paths
    scene : Scene (:mod:`.eye`)
    inner : float64 (INNER,), changed
    pose : float64 (5 + n + marks, 3), changed: (x, y, angle) of links and things when last looked; marks stay
    actions : float64 (steps, 8); with no steps the world is only looked at
    every_step : bool
        Look after every action; otherwise once, at the end.
    seen : uint8 (steps or 1, pixels, 3), written
    """
    now, ahead = np.empty((N_LINKS, 6)), np.empty((N_LINKS, 3))
    action, joint_rate = np.empty(actions.shape[1]), np.empty(4)
    for t in range(actions.shape[0]):
        for k in range(len(action)):
            action[k] = _clip(actions[t, k], -1.0, 1.0) * body.speeds[k]
        inner[HEAD] += _on_grid(action[2])
        inner[EYELID] = _clip(
            inner[EYELID] + _on_grid(action[3]), body.eyelid_low, body.eyelid_high
        )
        inner[TIME] += 1.0
        _move_things(read_body, write_body, wiring, paths, inner[TIME])
        for _ in range(SUBSTEPS):
            for i in range(
                N_LINKS
            ):  # where the links are, and where Chipmunk will have put them before it solves
                _read(read_body, wiring.links[i], wiring)
                for k in range(6):
                    now[i, k] = wiring.state[k]
                for k in range(3):
                    ahead[i, k] = now[i, k] + now[i, 3 + k] * DT
            base_vx, base_vy, base_w = _drive_base(inner, ahead, action, body.speeds)
            _drive_joints(inner, ahead, action, body, joint_rate)
            _force(write_body, wiring, body, 0, now, now[0, 0], now[0, 1], base_vx, base_vy, base_w)
            for side in range(
                2
            ):  # velocities and places of a rigid linkage, from the base outwards
                sign = 1.0 if side == 0 else -1.0
                x_to, y_to = (
                    -sign * body.base_radius * math.sin(ahead[0, 2]),
                    sign * body.base_radius * math.cos(ahead[0, 2]),
                )
                x, y = ahead[0, 0] + x_to, ahead[0, 1] + y_to
                vx, vy, w = base_vx - base_w * y_to, base_vy + base_w * x_to, base_w
                for i in range(1 + 2 * side, 3 + 2 * side):
                    w += joint_rate[i - 1]
                    x_to, y_to = (
                        body.arm_length / 2 * math.cos(ahead[i, 2]),
                        body.arm_length / 2 * math.sin(ahead[i, 2]),
                    )
                    place_x, place_y = x + x_to - now[i, 3] * DT, y + y_to - now[i, 4] * DT
                    _force(
                        write_body,
                        wiring,
                        body,
                        i,
                        now,
                        place_x,
                        place_y,
                        vx - w * y_to,
                        vy + w * x_to,
                        w,
                    )
                    x, y = x + 2 * x_to, y + 2 * y_to
                    vx, vy = vx - w * 2 * y_to, vy + w * 2 * x_to
            step_space(wiring.space, DT)
        if every_step:
            _look(read_body, wiring, scene, inner, pose, seen[t])
    if not every_step:
        _look(read_body, wiring, scene, inner, pose, seen[0])


@njit()
def _drive_base(inner, ahead, action, speeds):
    """Move the base's target and return the velocity (x, y, angular) that leads to it."""
    turn = _on_grid(action[1] * DT)
    heading = _within(inner[2], ahead[0, 2], SLACK[2])
    move_x, move_y = (
        _on_grid(action[0] * DT * math.cos(heading)),
        _on_grid(action[0] * DT * math.sin(heading)),
    )
    inner[0] = _within(inner[0], ahead[0, 0], SLACK[0]) + move_x
    inner[1] = _within(inner[1], ahead[0, 1], SLACK[1]) + move_y
    inner[2] = heading + turn
    return (
        _velocity(inner[0] - ahead[0, 0], move_x, speeds[0]),
        _velocity(inner[1] - ahead[0, 1], move_y, speeds[0]),
        _velocity(inner[2] - ahead[0, 2], turn, speeds[1]),
    )


@njit()
def _drive_joints(inner, ahead, action, body, out):
    """Move the joints' targets and write the joint velocities, relative to the parent link, that lead to them."""
    for j in range(4):
        angle = ahead[j + 1, 2] - ahead[PARENT[j + 1], 2]
        start = _within(inner[3 + j], angle, SLACK[3 + j])
        inner[3 + j] = _clip(
            start + _on_grid(body.joint_signs[j] * action[4 + j] * DT),
            body.joint_low[j],
            body.joint_high[j],
        )
        out[j] = _velocity(inner[3 + j] - angle, inner[3 + j] - start, body.speeds[4 + j])


@njit()
def _velocity(error, command, speed):
    """Velocity for one sub-step: what was commanded, plus what brings back a body that was pushed or lags."""
    return command / DT + _clip((error - command) / DT, -CORRECTION * speed, CORRECTION * speed)


@njit()
def _force(write_body, wiring, body, i, now, x, y, vx, vy, w):
    """Put link `i` at (x, y) and apply the force and torque after which Chipmunk starts to solve from the velocity (vx, vy, w)."""
    wiring.force[0], wiring.force[1] = x, y
    wiring.force[2] = body.mass[i] * (vx - now[i, 3] * body.damping) / DT
    wiring.force[3] = body.mass[i] * (vy - now[i, 4] * body.damping) / DT
    wiring.force[4] = body.moment[i] * (w - now[i, 5] * body.damping) / DT
    wiring.force_cursor[0] = 0
    write_body(wiring.links[i], wiring.force_channel)


@njit()
def _move_things(read_body, write_body, wiring, paths, time):
    """Give each moving thing the velocity that brings it to its place at `time`, one step ahead."""
    for i in range(len(wiring.movers)):
        _read(read_body, wiring.movers[i], wiring)
        x, y = path_point(paths.path[i], paths.corners[i], paths.phase[i] + paths.speed * time)
        wiring.velocity[0], wiring.velocity[1] = x - wiring.state[0], y - wiring.state[1]
        wiring.velocity_cursor[0] = 0
        write_body(wiring.movers[i], wiring.velocity_channel)


@njit()
def _look(read_body, wiring, scene, inner, pose, out):
    for i in range(len(wiring.bodies)):
        _read(read_body, wiring.bodies[i], wiring)
        pose[i, 0], pose[i, 1], pose[i, 2] = wiring.state[0], wiring.state[1], wiring.state[2]
    look(scene, (pose[0, 0], pose[0, 1], pose[0, 2] + inner[HEAD]), inner[EYELID], pose[1:], out)


@njit()
def _read(read_body, body, wiring):
    wiring.state_cursor[0] = 0
    read_body(body, wiring.state_channel)
