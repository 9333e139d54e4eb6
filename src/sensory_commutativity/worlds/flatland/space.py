"""Construction of the pymunk space: the agent's links and joints, the objects, and the walls."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pymunk

from .agent import N_LINKS, Polyphemus
from .room import FIXED, MOVING, Room, Situation
from .shapes import arm_outline, wall_blocks


def build_space(
    room: Room,
    agent: Polyphemus,
    situation: Situation,
    outlines: np.ndarray,
    states: np.ndarray,
) -> tuple[pymunk.Space, list[pymunk.Body]]:
    """Build the space of a situation.

    Parameters
    ----------
    room : Room
    agent : Polyphemus
    situation : Situation
    outlines : float64 (n, MAX_VERTICES, 2)
        From :func:`.shapes.object_outlines`.
    states : float64 (5 + n, 6)
        x, y, angle, velocity x, y, angular velocity of links and objects; units, rad, per step.

    Returns
    -------
    space : pymunk.Space
    bodies : list of pymunk.Body
        The agent's five links, then the objects.
    """
    space = pymunk.Space()
    space.damping = room.damping
    links = _add_agent(space, room, agent, states[:N_LINKS])
    objects = _add_objects(space, room, situation, outlines, states[N_LINKS:])
    for corners in wall_blocks(room):
        _add_shape(space, room, pymunk.Poly(space.static_body, corners))
    return space, links + objects


@lru_cache
def link_masses(agent: Polyphemus) -> tuple[list[float], list[float]]:
    """Mass and moment of inertia of each link."""
    base_moment = pymunk.moment_for_circle(agent.base_mass, 0, agent.base_radius)
    arm_moment = pymunk.moment_for_box(agent.arm_mass, (agent.arm_length, agent.arm_width))
    return [agent.base_mass] + 4 * [agent.arm_mass], [base_moment] + 4 * [arm_moment]


def _add_agent(
    space: pymunk.Space, room: Room, agent: Polyphemus, states: np.ndarray
) -> list[pymunk.Body]:
    no_self_collision = pymunk.ShapeFilter(group=1)
    links = []
    for i, (mass, moment) in enumerate(zip(*link_masses(agent), strict=True)):
        link = pymunk.Body(mass, moment)
        _set_state(link, states[i])
        shape: pymunk.Shape
        if i == 0:
            shape = pymunk.Circle(link, agent.base_radius)
        else:
            shape = pymunk.Poly(link, arm_outline(agent).tolist())
        shape.filter = no_self_collision
        _add_shape(space, room, shape, link)
        links.append(link)
    half = agent.arm_length / 2
    for upper, side in ((1, 1.0), (3, -1.0)):
        shoulder = (0, side * agent.base_radius)
        space.add(
            pymunk.PivotJoint(links[0], links[upper], shoulder, (-half, 0)),
            pymunk.PivotJoint(links[upper], links[upper + 1], (half, 0), (-half, 0)),
        )
    return links


def _add_objects(
    space: pymunk.Space,
    room: Room,
    situation: Situation,
    outlines: np.ndarray,
    states: np.ndarray,
) -> list[pymunk.Body]:
    objects = []
    for i, (kind, vertices) in enumerate(zip(situation.kind, situation.vertices, strict=True)):
        radius = situation.radius[i]
        if kind == FIXED:
            body = pymunk.Body(body_type=pymunk.Body.STATIC)
        elif kind == MOVING:
            body = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
        else:
            moment = pymunk.moment_for_circle(room.object_mass, 0, radius)
            body = pymunk.Body(room.object_mass, moment)
        _set_state(body, states[i])
        shape: pymunk.Shape
        if vertices == 0:
            shape = pymunk.Circle(body, radius)
        else:
            shape = pymunk.Poly(body, outlines[i, :vertices].tolist())
        _add_shape(space, room, shape, body)
        objects.append(body)
    return objects


def _add_shape(space: pymunk.Space, room: Room, shape: pymunk.Shape, *bodies: pymunk.Body) -> None:
    shape.friction = room.friction
    shape.elasticity = room.elasticity
    space.add(*bodies, shape)


def _set_state(body: pymunk.Body, state: np.ndarray) -> None:
    x, y, angle, vx, vy, angular_velocity = state.tolist()
    body.position, body.angle = (x, y), angle
    if vx or vy or angular_velocity:  # most bodies start at rest
        body.velocity, body.angular_velocity = (vx, vy), angular_velocity
