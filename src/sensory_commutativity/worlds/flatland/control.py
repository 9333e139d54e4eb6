"""The controller of the agent: a compiled loop over actions and sub-steps.

It has two requirements (``docs/differences.md``, "Control"). In free space every degree of freedom
must commute, to the last bit that the eye can see. And motion that is blocked must be *lost* rather
than made up for later, or walls would leave no trace.

Each command moves a *target*: the pose of the base and the joint angles. The links are given the
velocities that lead to the target, exactly those of a rigid linkage: in free motion, Chipmunk's
solver has nothing to correct. The velocities are handed over as forces, because Chipmunk applies
forces after it has found contacts and before it solves them. A target leads the body that it drives
by at most ``MAX_TRACKING_ERROR``, so blocked motion is lost. Commands are rounded to a fine grid on
which floating-point sums are exact and thus independent of their order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiled import njit
from .agent import N_LINKS, PARENT
from .eye import Scene, render
from .room import path_point

SUBSTEPS = 4  # authors: four sub-steps of 1/4 per action
DT = 1.0 / SUBSTEPS

GRID = 2.0**20
"""Grid points per unit or rad. Chosen: sums are exact, and 1e-6 is far below a pixel."""

MAX_TRACKING_ERROR = np.array([0.5, 0.5, 0.02, 0.02, 0.02, 0.02, 0.02])
"""By how much each target may lead: units, units, rad, ... Chosen: joints by less than one pixel
(0.0245 rad)."""

MAX_CORRECTION = 0.5
"""Velocity beyond the command with which a lagging body catches up, as a fraction of its top speed.
Chosen."""

# Indices of the controller state, float64 (STATE_SIZE,)
TARGET = slice(0, 7)  # x, y, heading of the base; four joint angles
HEAD, EYELID, TIME = 7, 8, 9  # rad; factor; steps since the start
STATE_SIZE = 10


class EngineHandles(NamedTuple):
    """Addresses of a space and its bodies, and channels to them (:mod:`.chipmunk`)."""

    space: int
    links: np.ndarray  # uint64 (5,)
    movers: np.ndarray  # uint64 (m,): the moving objects
    bodies: np.ndarray  # uint64 (5 + n,): links, then objects
    state_channel: int
    state: np.ndarray  # float64: x, y, angle, velocity x, y, angular velocity
    state_cursor: np.ndarray
    force_channel: int
    force: np.ndarray  # float64: x, y, force x, y, torque
    force_cursor: np.ndarray
    velocity_channel: int
    velocity: np.ndarray  # float64: velocity x, y
    velocity_cursor: np.ndarray


class AgentParameters(NamedTuple):
    """What the controller needs to know about the agent."""

    speeds: np.ndarray  # float64 (8,): motion per step for an action of 1
    joint_signs: np.ndarray  # float64 (4,)
    joint_low: np.ndarray  # float64 (4,), rad
    joint_high: np.ndarray  # float64 (4,), rad
    eyelid_low: float
    eyelid_high: float
    base_radius: float  # units
    arm_length: float  # units
    mass: np.ndarray  # float64 (5,)
    moment: np.ndarray  # float64 (5,)
    damping: float  # fraction of a body's velocity that Chipmunk keeps in one sub-step


class ObjectPaths(NamedTuple):
    """Paths of the `m` moving objects."""

    corners: np.ndarray  # int64 (m,)
    path: np.ndarray  # float64 (m, corners, 2), units
    phase: np.ndarray  # float64 (m,), units
    speed: float  # units per step


class CompiledState(NamedTuple):
    """All that :func:`advance` works on: handles and arrays of one world, not copies."""

    handles: EngineHandles
    agent: AgentParameters
    paths: ObjectPaths
    scene: Scene
    controller: np.ndarray  # float64 (STATE_SIZE,): target, head, eyelid, time
    poses: np.ndarray  # float64 (5 + n + zones, 3): x, y, angle at the last observation


@njit()
def advance(engine, state, actions, every_step, views):
    """Play `actions` and observe.

    Parameters
    ----------
    engine : Engine (:mod:`.chipmunk`)
    state : CompiledState
        Its arrays `controller` and `poses` are updated.
    actions : float64 (steps, 8)
        Without steps, the world is observed as it is.
    every_step : bool
        Observe after every action; otherwise once, at the end.
    views : uint8 (steps or 1, pixels, 3)
        Is written.
    """
    agent, controller, handles = state.agent, state.controller, state.handles
    links = np.empty((N_LINKS, 6))  # x, y, angle, velocity x, y, angular velocity
    ahead = np.empty((N_LINKS, 3))  # x, y, angle that Chipmunk integrates before it solves
    action, joint_rates = np.empty(actions.shape[1]), np.empty(4)
    for t in range(actions.shape[0]):
        for k in range(len(action)):
            action[k] = _clip(actions[t, k], -1.0, 1.0) * agent.speeds[k]
        controller[HEAD] += _round_to_grid(action[2])
        eyelid = controller[EYELID] + _round_to_grid(action[3])
        controller[EYELID] = _clip(eyelid, agent.eyelid_low, agent.eyelid_high)
        controller[TIME] += 1.0
        _move_objects(engine, handles, state.paths, controller[TIME])
        for _ in range(SUBSTEPS):
            for i in range(N_LINKS):
                _read(engine, handles.links[i], handles)
                for k in range(6):
                    links[i, k] = handles.state[k]
                for k in range(3):
                    ahead[i, k] = links[i, k] + links[i, 3 + k] * DT
            base_velocity = _drive_base(controller, ahead[0], action, agent.speeds)
            _drive_joints(controller, ahead[:, 2], action, agent, joint_rates)
            _drive_links(engine, handles, agent, links, ahead, base_velocity, joint_rates)
            engine.step(handles.space, DT)
        if every_step:
            _observe(engine, state, views[t])
    if not every_step:
        _observe(engine, state, views[0])


@njit()
def _clip(value, low, high):
    return min(max(value, low), high)


@njit()
def _clip_around(value, middle, margin):
    return _clip(value, middle - margin, middle + margin)


@njit()
def _round_to_grid(value):
    return math.floor(value * GRID + 0.5) / GRID


@njit()
def _tracking_velocity(error, command, top_speed):
    """Velocity for one sub-step: the command's, plus a limited correction of the other error."""
    limit = MAX_CORRECTION * top_speed
    return command / DT + _clip((error - command) / DT, -limit, limit)


@njit()
def _drive_base(controller, pose, action, speeds):
    """Move the target of the base; return the velocity (x, y, angular) that leads to it."""
    turn = _round_to_grid(action[1] * DT)
    heading = _clip_around(controller[2], pose[2], MAX_TRACKING_ERROR[2])
    move_x = _round_to_grid(action[0] * DT * math.cos(heading))
    move_y = _round_to_grid(action[0] * DT * math.sin(heading))
    controller[0] = _clip_around(controller[0], pose[0], MAX_TRACKING_ERROR[0]) + move_x
    controller[1] = _clip_around(controller[1], pose[1], MAX_TRACKING_ERROR[1]) + move_y
    controller[2] = heading + turn
    return (
        _tracking_velocity(controller[0] - pose[0], move_x, speeds[0]),
        _tracking_velocity(controller[1] - pose[1], move_y, speeds[0]),
        _tracking_velocity(controller[2] - pose[2], turn, speeds[1]),
    )


@njit()
def _drive_joints(controller, angles, action, agent, joint_rates):
    """Move the targets of the joints; write the velocities, relative to the parent link."""
    for j in range(4):
        angle = angles[j + 1] - angles[PARENT[j + 1]]
        start = _clip_around(controller[3 + j], angle, MAX_TRACKING_ERROR[3 + j])
        target = start + _round_to_grid(agent.joint_signs[j] * action[4 + j] * DT)
        controller[3 + j] = _clip(target, agent.joint_low[j], agent.joint_high[j])
        error, command = controller[3 + j] - angle, controller[3 + j] - start
        joint_rates[j] = _tracking_velocity(error, command, agent.speeds[4 + j])


@njit()
def _drive_links(engine, handles, agent, links, ahead, base_velocity, joint_rates):
    """Give all links the positions and velocities of a rigid linkage, from the base outwards."""
    base_vx, base_vy, base_w = base_velocity
    _apply_force(engine, handles, agent, links, 0, (links[0, 0], links[0, 1]), base_velocity)
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        # (dx, dy): from the centre of the base to the shoulder, then from a joint to the centre of
        # the segment that it moves
        dx = -sign * agent.base_radius * math.sin(ahead[0, 2])
        dy = sign * agent.base_radius * math.cos(ahead[0, 2])
        x, y = ahead[0, 0] + dx, ahead[0, 1] + dy
        vx, vy, w = base_vx - base_w * dy, base_vy + base_w * dx, base_w
        for i in range(1 + 2 * side, 3 + 2 * side):
            w += joint_rates[i - 1]
            dx = agent.arm_length / 2 * math.cos(ahead[i, 2])
            dy = agent.arm_length / 2 * math.sin(ahead[i, 2])
            position = x + dx - links[i, 3] * DT, y + dy - links[i, 4] * DT
            velocity = vx - w * dy, vy + w * dx, w
            _apply_force(engine, handles, agent, links, i, position, velocity)
            x, y = x + 2 * dx, y + 2 * dy
            vx, vy = vx - w * 2 * dy, vy + w * 2 * dx


@njit()
def _apply_force(engine, handles, agent, links, i, position, velocity):
    """Set the position of link `i`, and the force and torque that lead to `velocity`.

    Chipmunk starts to solve from that velocity.
    """
    vx, vy, w = velocity
    handles.force[0], handles.force[1] = position
    handles.force[2] = agent.mass[i] * (vx - links[i, 3] * agent.damping) / DT
    handles.force[3] = agent.mass[i] * (vy - links[i, 4] * agent.damping) / DT
    handles.force[4] = agent.moment[i] * (w - links[i, 5] * agent.damping) / DT
    handles.force_cursor[0] = 0
    engine.write_body(handles.links[i], handles.force_channel)


@njit()
def _move_objects(engine, handles, paths, time):
    """Give each moving object the velocity that brings it to its position at `time`.

    That is one step ahead.
    """
    for i in range(len(handles.movers)):
        _read(engine, handles.movers[i], handles)
        x, y = path_point(paths.path[i], paths.corners[i], paths.phase[i] + paths.speed * time)
        handles.velocity[0] = x - handles.state[0]
        handles.velocity[1] = y - handles.state[1]
        handles.velocity_cursor[0] = 0
        engine.write_body(handles.movers[i], handles.velocity_channel)


@njit()
def _observe(engine, state, view):
    """Read the poses of all bodies and render the view; the agent does not see its own base."""
    handles, poses, controller = state.handles, state.poses, state.controller
    for i in range(len(handles.bodies)):
        _read(engine, handles.bodies[i], handles)
        poses[i] = handles.state[:3]
    eye = poses[0, 0], poses[0, 1], poses[0, 2] + controller[HEAD]
    render(state.scene, eye, controller[EYELID], poses[1:], view)


@njit()
def _read(engine, body, handles):
    handles.state_cursor[0] = 0
    engine.read_body(body, handles.state_channel)
