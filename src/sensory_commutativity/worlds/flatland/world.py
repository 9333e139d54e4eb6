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

import numpy as np
import pymunk

from . import chipmunk
from .agent import N_LINKS, Polyphemus
from .control import (
    DT,
    EYELID,
    STATE_SIZE,
    TARGET,
    AgentParameters,
    CompiledState,
    EngineHandles,
    ObjectPaths,
    advance,
)
from .eye import Scene, ray_directions
from .room import MAX_VERTICES, MOVING, WALL_COLOURS, Room, Situation, sample_situation
from .shapes import arm_outline, object_outlines, wall_lines
from .space import build_space, link_masses

ARM_COLOURS = np.array([(255, 255, 255), (200, 200, 200)] * 2, np.uint8)
"""Upper arm and forearm, left and right. Chosen: unlike any wall or object."""


@dataclass(frozen=True)
class FlatlandSnapshot:
    """A start situation, and the present state in it.

    Attributes
    ----------
    situation : Situation
    bodies : float64 (5 + n, 6)
        x, y, angle, velocity x, y, angular velocity of links and objects; units, rad, per step.
    controller_state : float64 (STATE_SIZE,)
        Target, head, eyelid, time (:mod:`.control`).
    """

    situation: Situation
    bodies: np.ndarray
    controller_state: np.ndarray


class FlatlandWorld:
    """A :class:`~sensory_commutativity.scp.world.World` on pymunk.

    Equal seeds and actions give bit-identical observations. Methods other than :meth:`reset`,
    :meth:`restore` and :meth:`enter` raise RuntimeError before the first of these calls, and
    ValueError for actions of the wrong shape or with values that are not finite.

    Parameters
    ----------
    room : Room, optional
    agent : Polyphemus, optional
    """

    def __init__(self, room: Room | None = None, agent: Polyphemus | None = None):
        self.room = room or Room()
        self.agent = agent or Polyphemus()
        self.dofs = self.agent.dofs
        self._state_channel = chipmunk.Channel(chipmunk.POSE_AND_VELOCITY)
        self._force_channel = chipmunk.Channel(chipmunk.POSITION_AND_FORCE)
        self._velocity_channel = chipmunk.Channel(chipmunk.VELOCITY)
        self._view = np.zeros((1, self.agent.pixels, 3), np.uint8)
        self._space: pymunk.Space | None = None
        self._situation: Situation
        self._start: FlatlandSnapshot
        self._unmoved = False  # the space is as it was built from self._start

    name = "Flatland"

    # ---- the protocol World ---------------------------------------------------------------------

    def reset(self, rng: np.random.Generator) -> None:
        """Sample a start situation and enter it; raises PlacementError if the room is too full."""
        self.enter(sample_situation(self.room, self.agent, rng))

    def snapshot(self) -> FlatlandSnapshot:
        """Return the present state.

        Chipmunk's memory of contacts cannot be read. A world that has moved is therefore rebuilt
        from its own snapshot, and goes on exactly as any world restored from it does.
        """
        if not self._unmoved:
            self._require_situation()
            controller_state = self._state.controller.copy()
            self.restore(FlatlandSnapshot(self._situation, self._body_states(), controller_state))
        return self._start

    def restore(self, snapshot: FlatlandSnapshot) -> None:
        """Return to the state of `snapshot`, by rebuilding the space."""
        if self._unmoved and snapshot is self._start:
            return
        if self._space is None or snapshot.situation is not self._situation:
            self._situation = snapshot.situation
            self._outlines = object_outlines(self._situation)
            self._scene = _build_scene(self.room, self.agent, self._situation, self._outlines)
        self._start = snapshot
        self._build(snapshot)
        self._unmoved = True

    def step(self, action: np.ndarray) -> None:
        """Play one action: float (8,), clipped to [-1, 1]."""
        self._advance(np.asarray(action, np.float64)[None], False, self._view)

    def observe(self) -> np.ndarray:
        """Return the view: uint8 (pixels, 3), RGB from right to left."""
        self._advance(np.zeros((0, len(self.dofs))), False, self._view)
        return self._view[0].copy()

    # ---- beyond the protocol --------------------------------------------------------------------

    def enter(self, situation: Situation) -> None:
        """Start at rest in `situation`."""
        bodies = np.zeros((N_LINKS + situation.n_objects, 6))
        bodies[:N_LINKS, :3] = situation.links
        bodies[N_LINKS:, :3] = situation.pose
        controller_state = np.zeros(STATE_SIZE)
        controller_state[TARGET] = [*situation.links[0], *self.agent.rest_angles]
        controller_state[EYELID] = 1.0
        self.restore(FlatlandSnapshot(situation, bodies, controller_state))

    def play(self, actions: np.ndarray) -> None:
        """Play actions, float (steps, 8): faster than single steps, with the same result."""
        self._advance(np.asarray(actions, np.float64), False, self._view)

    def rollout(self, actions: np.ndarray) -> np.ndarray:
        """Play actions, float (steps, 8); return the view after each, uint8 (steps, pixels, 3)."""
        views = np.zeros((len(actions), self.agent.pixels, 3), np.uint8)
        self._advance(np.asarray(actions, np.float64), True, views)
        return views

    @property
    def situation(self) -> Situation:
        """The start situation that was last entered."""
        return self._situation

    @property
    def controller_state(self) -> np.ndarray:
        """State of the controller, float64 (STATE_SIZE,), see :mod:`.control`. A copy."""
        return self._state.controller.copy()

    def poses(self) -> np.ndarray:
        """Poses of the five links, then of the objects: x, y, angle; units, rad; (5 + n, 3)."""
        return self._body_states()[:, :3]

    def compiled_state(self) -> CompiledState:
        """What the compiled loop works on, for loops over many worlds (:mod:`.vector`).

        These are addresses and arrays of this world, not copies: valid until its next reset,
        restore or snapshot, and only while it exists.
        """
        self._unmoved = False  # the caller may advance the space
        return self._state

    # ---- internals ------------------------------------------------------------------------------

    def _advance(self, actions: np.ndarray, every_step: bool, views: np.ndarray) -> None:
        self._require_situation()
        if actions.ndim != 2 or actions.shape[1] != len(self.dofs):
            raise ValueError(
                f"an action has {len(self.dofs)} elements, one per degree of freedom; "
                f"got an array of shape {actions.shape[1:]}"
            )
        if not np.isfinite(actions).all():
            raise ValueError("an action holds a value that is not finite; actions lie in [-1, 1]")
        self._unmoved = self._unmoved and len(actions) == 0
        actions = np.ascontiguousarray(actions)
        advance(chipmunk.ENGINE, self._state, actions, every_step, views)

    def _require_situation(self) -> None:
        if self._space is None:
            raise RuntimeError("the world has no situation yet: call reset(rng) first")

    def _body_states(self) -> np.ndarray:
        states = [(*b.position, b.angle, *b.velocity, b.angular_velocity) for b in self._bodies]
        return np.array(states).reshape(-1, 6)

    def _build(self, snapshot: FlatlandSnapshot) -> None:
        room, agent, situation = self.room, self.agent, snapshot.situation
        self._space, self._bodies = build_space(
            room, agent, situation, self._outlines, snapshot.bodies
        )
        addresses = np.array([chipmunk.body_address(b) for b in self._bodies], np.uint64)
        moving = situation.kind == MOVING
        state, force, velocity = self._state_channel, self._force_channel, self._velocity_channel
        handles = EngineHandles(
            chipmunk.space_address(self._space),
            addresses[:N_LINKS], addresses[N_LINKS:][moving], addresses,
            state.address, state.values, state.cursor,
            force.address, force.values, force.cursor,
            velocity.address, velocity.values, velocity.cursor,
        )  # fmt: skip
        corners, path = situation.corners[moving], situation.path[moving]
        paths = ObjectPaths(corners, path, situation.phase[moving], room.path_speed)
        poses = np.zeros((len(addresses) + len(room.zones), 3))
        for i, zone in enumerate(room.zones):
            poses[len(addresses) + i, :2] = zone.x, zone.y
        self._state = CompiledState(
            handles,
            _agent_parameters(agent, room.damping),
            paths,
            self._scene,
            snapshot.controller_state.copy(),
            poses,
        )


@lru_cache
def _agent_parameters(agent: Polyphemus, damping: float) -> AgentParameters:
    mass, moment = link_masses(agent)
    eyelid_low, eyelid_high = agent.eyelid_range
    return AgentParameters(
        speeds=np.array([dof.speed for dof in agent.dofs]),
        joint_signs=agent.joint_signs,
        joint_low=agent.rest_angles - agent.joint_range,
        joint_high=agent.rest_angles + agent.joint_range,
        eyelid_low=eyelid_low,
        eyelid_high=eyelid_high,
        base_radius=agent.base_radius,
        arm_length=agent.arm_length,
        mass=np.array(mass),
        moment=np.array(moment),
        damping=damping**DT,
    )


def _build_scene(
    room: Room, agent: Polyphemus, situation: Situation, outlines: np.ndarray
) -> Scene:
    """What the eye sees: the arm segments, the objects, then the zones. Base and head are not seen.

    The order is that of the rows of ``CompiledState.poses`` after the base.
    """
    n_zones = len(room.zones)
    arms = np.zeros((N_LINKS - 1, MAX_VERTICES, 2))
    arms[:, :4] = arm_outline(agent)
    arm_radius = math.hypot(agent.arm_length, agent.arm_width) / 2
    zone_colours = np.array([zone.colour for zone in room.zones], np.uint8).reshape(-1, 3)
    return Scene(
        rays=_rays(agent),
        field_of_view=agent.field_of_view,
        view_range=agent.view_range,
        outlines=np.concatenate([arms, outlines, np.zeros((n_zones, MAX_VERTICES, 2))]),
        vertices=np.concatenate([[4] * 4, situation.vertices, np.zeros(n_zones, np.int64)]),
        radius=np.concatenate(
            [[arm_radius] * 4, situation.radius, [zone.radius for zone in room.zones]]
        ),
        colour=np.concatenate([ARM_COLOURS, situation.colour, zone_colours]),
        walls=wall_lines(room),
        wall_colour=WALL_COLOURS,
    )


@lru_cache
def _rays(agent: Polyphemus) -> np.ndarray:
    return ray_directions(agent.pixels, agent.field_of_view)
