"""Flatland: Polyphemus in a room, seen through its one eye (paper, section III-A).

>>> import numpy as np
>>> world = FlatlandWorld()
>>> world.reset(np.random.default_rng(0))
>>> world.step(np.array([1, 0, 0, 0, 0, 0, 0, 0]))      # one step forward
>>> world.observe().shape                               # 64 RGB pixels
(64, 3)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import pymunk

from . import chipmunk
from .agent import N_LINKS, Polyphemus
from .control import DT, EYELID, INNER, Body, Paths, Wiring, advance
from .eye import Scene, ray_directions
from .room import FIXED, MAX_VERTICES, MOVING, WALL_COLOURS, Room, Situation, draw_situation

ARM_COLOURS = np.array(
    [(255, 255, 255), (200, 200, 200)] * 2, np.uint8
)  # chosen: unlike any wall or thing; upper arm, forearm
_NOTHING = np.zeros((0, 8))


@dataclass(frozen=True)
class FlatlandSnapshot:
    """A situation and where everything has got to in it.

    Attributes
    ----------
    situation : Situation
    bodies : float64 (5 + n, 6)
        x, y, angle, velocity x, y, angular velocity of links and things; units, rad, per step.
    inner : float64 (INNER,)
        Targets of the control, head, eyelid, time.
    """

    situation: Situation
    bodies: np.ndarray
    inner: np.ndarray


class Parts(NamedTuple):
    """What the compiled loop works on: see :func:`.control.advance`."""

    wiring: Wiring
    body: Body
    paths: Paths
    scene: Scene
    inner: np.ndarray
    pose: np.ndarray


class FlatlandWorld:
    """A :class:`~sensory_commutativity.worlds.base.World` on pymunk. Bit-identical for equal seeds and actions.

    Parameters
    ----------
    room : Room
    agent : Polyphemus
    """

    def __init__(self, room: Room | None = None, agent: Polyphemus | None = None):
        self.room = room or Room()
        self.agent = agent or Polyphemus()
        self.dofs = self.agent.dofs
        self._state = chipmunk.Channel(chipmunk.POSE_AND_VELOCITY)
        self._force = chipmunk.Channel(chipmunk.POSITION_AND_FORCE)
        self._velocity = chipmunk.Channel(chipmunk.VELOCITY)
        self._seen = np.zeros((1, self.agent.pixels, 3), np.uint8)
        self._space: pymunk.Space | None = None
        self._fresh = False  # nothing has moved since the space was built

    # ---- the five methods ------------------------------------------------------------------------------------------------

    def reset(self, rng: np.random.Generator) -> None:
        """Draw a start situation and enter it. Raises PlacementError when the room is too full."""
        self.enter(draw_situation(self.room, self.agent, rng))

    def snapshot(self) -> FlatlandSnapshot:
        """Return the present situation; afterwards this world goes on exactly as one restored from it does.

        Chipmunk remembers contacts in ways that cannot be read, so a world that has moved is rebuilt from its own snapshot.
        """
        if not self._fresh:
            self._need_situation()
            self.restore(FlatlandSnapshot(self._situation, self._bodies(), self._inner.copy()))
        return self._start

    def restore(self, snapshot: FlatlandSnapshot) -> None:
        """Put the world back, by building it anew."""
        if self._fresh and snapshot is self._start:
            return
        if self._space is None or snapshot.situation is not self._situation:
            self._situation = snapshot.situation
            self._outlines = _outlines(self._situation)
            self._scene = _scene(self.agent, self.room, self._situation, self._outlines)
        self._start = snapshot
        self._inner = snapshot.inner.copy()
        self._build(snapshot)
        self._fresh = True

    def step(self, action: np.ndarray) -> None:
        """Play one action, float (8,), clipped to [-1, 1]."""
        self._advance(np.asarray(action, np.float64)[None], False, self._seen)

    def observe(self) -> np.ndarray:
        """The view, uint8 (pixels, 3), from right to left."""
        self._advance(_NOTHING, False, self._seen)
        return self._seen[0].copy()

    # ---- many steps at once, and what drawings need ----------------------------------------------------------------------

    def enter(self, situation: Situation) -> None:
        """Start at rest in `situation`."""
        bodies = np.zeros((N_LINKS + situation.n_things, 6))
        bodies[:N_LINKS, :3], bodies[N_LINKS:, :3] = situation.links, situation.pose
        inner = np.zeros(INNER)
        inner[:3], inner[3:7], inner[EYELID] = situation.links[0], self.agent.rest_angles, 1.0
        self.restore(FlatlandSnapshot(situation, bodies, inner))

    def play(self, actions: np.ndarray) -> None:
        """Play actions, float (steps, 8); ends exactly where single steps would."""
        self._advance(np.asarray(actions, np.float64), False, self._seen)

    def watch(self, actions: np.ndarray) -> np.ndarray:
        """Play actions, float (steps, 8), and return what is seen after each: uint8 (steps, pixels, 3)."""
        seen = np.zeros((len(actions), self.agent.pixels, 3), np.uint8)
        self._advance(np.asarray(actions, np.float64), True, seen)
        return seen

    @property
    def situation(self) -> Situation:
        """The start situation that the world is in."""
        return self._situation

    @property
    def inner(self) -> np.ndarray:
        """The control's inner state, float64 (INNER,): see :mod:`.control`. A copy."""
        return self._inner.copy()

    def poses(self) -> np.ndarray:
        """(x, y, angle) of the five links, then of the things, float64 (5 + n, 3); units, rad."""
        return self._bodies()[:, :3]

    def parts(self) -> Parts:
        """What the compiled loop works on, for loops over many worlds (:mod:`.vector`).

        Not copies, but addresses and arrays of this world: valid until its next reset or restore, and only while it lives.
        """
        self._fresh = False  # whoever has the parts may move them
        return Parts(self._wiring, self._body, self._paths, self._scene, self._inner, self._pose)

    # ---- building --------------------------------------------------------------------------------------------------------

    def _advance(self, actions: np.ndarray, every_step: bool, seen: np.ndarray) -> None:
        self._need_situation()
        if actions.ndim != 2 or actions.shape[1] != len(self.dofs):
            raise ValueError(
                f"an action has {len(self.dofs)} elements, one per degree of freedom; got an array of shape {actions.shape[1:]}"
            )
        if not np.isfinite(actions).all():
            raise ValueError("an action holds a value that is not finite; actions lie in [-1, 1]")
        self._fresh = self._fresh and len(actions) == 0
        advance(
            chipmunk.STEP, chipmunk.READ_BODY, chipmunk.WRITE_BODY, self._wiring, self._body, self._paths, self._scene,
            self._inner, self._pose, np.ascontiguousarray(actions), every_step, seen,
        )  # fmt: skip

    def _need_situation(self) -> None:
        if self._space is None:
            raise RuntimeError("the world has no situation yet: call reset(rng) first")

    def _bodies(self) -> np.ndarray:
        state = [(*b.position, b.angle, *b.velocity, b.angular_velocity) for b in self._all_bodies]
        return np.array(state).reshape(-1, 6)

    def _build(self, snapshot: FlatlandSnapshot) -> None:
        room, agent, situation = self.room, self.agent, snapshot.situation
        space = pymunk.Space()
        space.damping = room.damping
        links = self._add_agent(space, snapshot.bodies)
        things = self._add_things(space, snapshot)
        self._space, self._all_bodies = space, links + things
        self._add_walls(space)

        addresses = np.array([chipmunk.body_address(b) for b in self._all_bodies], np.uint64)
        moving = situation.kind == MOVING
        self._wiring = Wiring(
            chipmunk.space_address(space), addresses[:N_LINKS], addresses[N_LINKS:][moving], addresses,
            self._state.address, self._state.values, self._state.cursor,
            self._force.address, self._force.values, self._force.cursor,
            self._velocity.address, self._velocity.values, self._velocity.cursor,
        )  # fmt: skip
        self._paths = Paths(
            situation.corners[moving],
            situation.path[moving],
            situation.phase[moving],
            room.path_speed,
        )
        self._pose = np.zeros((len(addresses) + len(room.marks), 3))
        for i, mark in enumerate(room.marks):
            self._pose[len(addresses) + i, :2] = mark.x, mark.y
        self._body = _body(agent, room.damping)

    def _add_agent(self, space: pymunk.Space, bodies: np.ndarray) -> list[pymunk.Body]:
        agent = self.agent
        own = pymunk.ShapeFilter(group=1)  # the agent does not collide with itself
        mass, moment = _masses(agent)
        links = []
        for i in range(N_LINKS):
            link = _place(pymunk.Body(mass[i], moment[i]), bodies[i])
            shape = (
                pymunk.Circle(link, agent.base_radius)
                if i == 0
                else pymunk.Poly(link, _arm_corners(agent).tolist())
            )
            shape.filter, shape.friction, shape.elasticity = (
                own,
                self.room.friction,
                self.room.elasticity,
            )
            space.add(link, shape)
            links.append(link)
        half = agent.arm_length / 2
        for upper, side in ((1, 1.0), (3, -1.0)):
            space.add(
                pymunk.PivotJoint(
                    links[0], links[upper], (0, side * agent.base_radius), (-half, 0)
                ),
                pymunk.PivotJoint(links[upper], links[upper + 1], (half, 0), (-half, 0)),
            )
        return links

    def _add_things(self, space: pymunk.Space, snapshot: FlatlandSnapshot) -> list[pymunk.Body]:
        room, situation, things = self.room, snapshot.situation, []
        for i in range(situation.n_things):
            radius, corners = situation.radius[i], situation.vertices[i]
            if situation.kind[i] == FIXED:
                thing = pymunk.Body(body_type=pymunk.Body.STATIC)
            elif situation.kind[i] == MOVING:
                thing = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
            else:
                thing = pymunk.Body(
                    room.thing_mass, pymunk.moment_for_circle(room.thing_mass, 0, radius)
                )
            _place(thing, snapshot.bodies[N_LINKS + i])
            shape = (
                pymunk.Circle(thing, radius)
                if corners == 0
                else pymunk.Poly(thing, self._outlines[i, :corners].tolist())
            )
            shape.friction, shape.elasticity = room.friction, room.elasticity
            space.add(thing, shape)
            things.append(thing)
        return things

    def _add_walls(self, space: pymunk.Space) -> None:
        for corners in _wall_blocks(self.room):
            wall = pymunk.Poly(space.static_body, corners)
            wall.friction, wall.elasticity = self.room.friction, self.room.elasticity
            space.add(wall)


def _place(body: pymunk.Body, state: np.ndarray) -> pymunk.Body:
    x, y, angle, vx, vy, angular = state.tolist()
    body.position, body.angle = (x, y), angle
    if vx or vy or angular:
        body.velocity, body.angular_velocity = (vx, vy), angular
    return body


@lru_cache
def _unit_polygon(corners: int) -> np.ndarray:
    """Corners of a regular polygon in the unit circle, counter-clockwise: float64 (corners, 2)."""
    angles = 2 * math.pi * np.arange(corners) / max(1, corners)
    return np.stack([np.cos(angles), np.sin(angles)], 1)


def _outlines(situation: Situation) -> np.ndarray:
    """Corners of the things in their own frames, float64 (n, MAX_VERTICES, 2); zeros where a thing has fewer."""
    outlines = np.zeros((situation.n_things, MAX_VERTICES, 2))
    for i, corners in enumerate(situation.vertices):
        outlines[i, :corners] = situation.radius[i] * _unit_polygon(corners)
    return outlines


@lru_cache
def _arm_corners(agent: Polyphemus) -> np.ndarray:
    x, y = agent.arm_length / 2, agent.arm_width / 2
    return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])


@lru_cache
def _masses(agent: Polyphemus) -> tuple[list[float], list[float]]:
    arm = pymunk.moment_for_box(agent.arm_mass, (agent.arm_length, agent.arm_width))
    return [agent.base_mass] + 4 * [agent.arm_mass], [
        pymunk.moment_for_circle(agent.base_mass, 0, agent.base_radius)
    ] + 4 * [arm]


@lru_cache
def _walls(room: Room) -> np.ndarray:
    """End points of the four walls' middle lines, float64 (4, 4). They are seen even where they are not solid."""
    w, h = room.width, room.height
    return np.array([(w, 0, 0, 0), (w, h, w, 0), (0, h, w, h), (0, 0, 0, h)], np.float64)


@lru_cache
def _wall_blocks(room: Room) -> tuple[list[tuple[float, float]], ...]:
    """Corners of each wall as a block that goes on outwards, so that nothing can jump over it in one sub-step."""
    inside, outside = room.wall_thickness / 2, room.wall_backing
    blocks: list[list[tuple[float, float]]] = []
    if not room.walls:
        return ()
    for x1, y1, x2, y2 in _walls(room):
        along = np.array([x2 - x1, y2 - y1]) / math.hypot(x2 - x1, y2 - y1)
        outwards = np.array([-along[1], along[0]])
        first, second = np.array([x1, y1]) - outside * along, np.array([x2, y2]) + outside * along
        corners = (
            first - inside * outwards,
            second - inside * outwards,
            second + outside * outwards,
            first + outside * outwards,
        )
        blocks.append([(float(x), float(y)) for x, y in corners])
    return tuple(blocks)


@lru_cache
def _body(agent: Polyphemus, damping: float) -> Body:
    mass, moment = _masses(agent)
    low, high = agent.eyelid_range
    return Body(
        np.array([dof.speed for dof in agent.dofs]), agent.joint_signs,
        agent.rest_angles - agent.joint_range, agent.rest_angles + agent.joint_range, low, high,
        agent.base_radius, agent.arm_length, np.array(mass), np.array(moment), damping**DT,
    )  # fmt: skip


def _scene(agent: Polyphemus, room: Room, situation: Situation, outlines: np.ndarray) -> Scene:
    """What the eye sees: the agent's arm segments first, then the things, then the marks; its own base and head it does not see."""
    arms, marks = np.zeros((4, MAX_VERTICES, 2)), np.zeros((len(room.marks), MAX_VERTICES, 2))
    arms[:, :4] = _arm_corners(agent)
    reach = math.hypot(agent.arm_length, agent.arm_width) / 2
    return Scene(
        _rays(agent), agent.field_of_view, agent.view_range,
        np.concatenate([arms, outlines, marks]), np.concatenate([[4] * 4, situation.vertices, np.zeros(len(marks), np.int64)]),
        np.concatenate([[reach] * 4, situation.radius, [mark.radius for mark in room.marks]]),
        np.concatenate([ARM_COLOURS, situation.colour, np.array([mark.colour for mark in room.marks], np.uint8).reshape(-1, 3)]),
        _walls(room), WALL_COLOURS,
    )  # fmt: skip


@lru_cache
def _rays(agent: Polyphemus) -> np.ndarray:
    return ray_directions(agent.pixels, agent.field_of_view)
