"""Many Flatland rooms in one process: a compiled loop over rooms, behind Gymnasium's vector API."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ...compiled import njit
from . import chipmunk
from .agent import Polyphemus
from .control import CompiledState, EngineHandles, ObjectPaths, advance
from .environment import MAX_EPISODE_STEPS, action_space, observation_space
from .eye import Scene
from .room import Room
from .world import FlatlandWorld

_ROOM_ARRAYS = {
    "handles": ("links", "movers", "bodies"),
    "paths": ("corners", "path", "phase"),
    "scene": ("outlines", "vertices", "radius", "colour"),
}
"""Fields of a CompiledState whose named arrays differ between rooms, besides `controller` and
`poses`. All else is shared, except the address of the space."""


@njit()
def advance_rooms(engine, spaces, state, actions, rooms, skip, views):
    """Advance `rooms` by one step, as :func:`.control.advance` does for one room.

    Parameters
    ----------
    engine : Engine (:mod:`.chipmunk`)
    spaces : uint64 (num_envs,)
        Addresses of the spaces.
    state : CompiledState
        The arrays of `_ROOM_ARRAYS`, `controller` and `poses` have a first dimension over rooms.
    actions : float64 (num_envs, 8)
    rooms : int64 (k,)
    skip : bool (num_envs,)
        Rooms that are only observed.
    views : uint8 (num_envs, pixels, 3)
        Is written.
    """
    handles, paths, scene = state.handles, state.paths, state.scene
    for r in rooms:
        room_handles = EngineHandles(
            spaces[r], handles.links[r], handles.movers[r], handles.bodies[r],
            handles.state_channel, handles.state, handles.state_cursor,
            handles.force_channel, handles.force, handles.force_cursor,
            handles.velocity_channel, handles.velocity, handles.velocity_cursor,
        )  # fmt: skip
        room_paths = ObjectPaths(paths.corners[r], paths.path[r], paths.phase[r], paths.speed)
        room_scene = Scene(
            scene.rays, scene.field_of_view, scene.view_range,
            scene.outlines[r], scene.vertices[r], scene.radius[r], scene.colour[r],
            scene.walls, scene.wall_colour,
        )  # fmt: skip
        room_state = CompiledState(
            room_handles, state.agent, room_paths, room_scene, state.controller[r], state.poses[r]
        )
        first = r + 1 if skip[r] else r
        advance(engine, room_state, actions[first : r + 1], False, views[r : r + 1])


class FlatlandVectorEnv(VectorEnv):
    """`num_envs` rooms, stepped together.

    Each room gives, bit for bit, what a :class:`.environment.FlatlandEnv` with its seed gives.

    Parameters
    ----------
    num_envs : int
    room : Room, optional
    agent : Polyphemus, optional
    max_episode_steps : int
        Episodes are truncated after this many steps.
    autoreset_mode : AutoresetMode
        ``NEXT_STEP``: the step after the end of an episode resets the room and ignores its action.
        ``SAME_STEP``: the last step of an episode resets the room; it returns the first observation
        of the new episode, and the last one of the old in ``infos["final_obs"]``.
    """

    def __init__(
        self,
        num_envs: int = 1,
        room: Room | None = None,
        agent: Polyphemus | None = None,
        max_episode_steps: int = MAX_EPISODE_STEPS,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
    ):
        if autoreset_mode not in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP):
            raise ValueError(f"autoreset_mode must be NEXT_STEP or SAME_STEP, got {autoreset_mode}")
        self.metadata = {"render_modes": [], "autoreset_mode": autoreset_mode}
        self._same_step = autoreset_mode == AutoresetMode.SAME_STEP
        self.num_envs = num_envs
        self.max_episode_steps = max_episode_steps
        self._worlds = [FlatlandWorld(room, agent) for _ in range(num_envs)]
        agent = self._worlds[0].agent
        self.single_action_space = action_space(agent)
        self.single_observation_space = observation_space(agent)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._rngs: list[np.random.Generator] = []
        self._views = np.zeros((num_envs, agent.pixels, 3), np.uint8)
        self._steps = np.zeros(num_envs, np.int64)
        self._ended = np.zeros(num_envs, bool)
        self._spaces = np.zeros(num_envs, np.uint64)
        self._state: CompiledState  # arrays of all rooms, allocated by the first reset
        self._allocated = False

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Reset all rooms.

        With an integer seed, room i gets seed + i. Without a seed, the rooms' generators go on.
        """
        seeds: Sequence[int | None]
        if isinstance(seed, (int, np.integer)):
            seeds = [int(seed) + i for i in range(self.num_envs)]
        elif seed is None:
            seeds = [None] * self.num_envs
        else:
            seeds = seed
        if len(seeds) != self.num_envs:
            raise ValueError(f"{self.num_envs} rooms need {self.num_envs} seeds, got {len(seeds)}")
        self._rngs = [
            self._rngs[i] if self._rngs and s is None else seeding.np_random(s)[0]
            for i, s in enumerate(seeds)
        ]
        self._reset_rooms(np.arange(self.num_envs))
        return self._views.copy(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Step every room; return observations, rewards, terminations, truncations, infos.

        Raises
        ------
        RuntimeError
            Before the first :meth:`reset`.
        ValueError
            If `actions` have the wrong shape or values that are not finite.
        """
        if not self._allocated:
            raise RuntimeError("the rooms have no situation yet: call reset() first")
        actions = np.asarray(actions, np.float64)
        shape = self.num_envs, len(self._worlds[0].dofs)
        if actions.shape != shape:
            raise ValueError(f"actions must have the shape {shape}, got {actions.shape}")
        if not np.isfinite(actions).all():
            raise ValueError("an action holds a value that is not finite; actions lie in [-1, 1]")
        resetting = self._ended.copy()  # none with SAME_STEP
        for r in np.flatnonzero(resetting).tolist():
            self._reset_room(r)
        self._steps[~resetting] += 1
        self._advance(actions, np.arange(self.num_envs), resetting)
        rewards, terminated = self._rewards_and_terminations()
        terminated &= ~resetting
        truncated = (self._steps >= self.max_episode_steps) & ~terminated
        self._ended = terminated | truncated
        infos: dict[str, Any] = {}
        for r in np.flatnonzero(self._ended).tolist():
            info = self._final_info(r)
            if self._same_step:
                info = {"final_obs": self._views[r].copy(), "final_info": info}
            infos = self._add_info(infos, info, r)
        if self._same_step and self._ended.any():
            self._reset_rooms(np.flatnonzero(self._ended))
        return self._views.copy(), np.where(resetting, 0.0, rewards), terminated, truncated, infos

    def _rewards_and_terminations(self) -> tuple[np.ndarray, np.ndarray]:
        """Reward, float64, and termination, bool, of every room in its present state.

        Tasks override this.
        """
        return np.zeros(self.num_envs), np.zeros(self.num_envs, bool)

    def _final_info(self, r: int) -> dict[str, Any]:
        """Info of the single environment at the end of an episode, for room `r`.

        Tasks override this.
        """
        return {}

    def _advance(self, actions: np.ndarray, rooms: np.ndarray, skip: np.ndarray) -> None:
        advance_rooms(chipmunk.ENGINE, self._spaces, self._state, actions, rooms, skip, self._views)

    def _reset_rooms(self, rooms: np.ndarray) -> None:
        """Sample new situations for `rooms` and observe them."""
        for r in rooms.tolist():
            self._reset_room(r)
        no_actions = np.zeros((self.num_envs, len(self._worlds[0].dofs)))
        self._advance(no_actions, rooms, np.ones(self.num_envs, bool))

    def _reset_room(self, r: int) -> None:
        """Sample a new situation for room `r` and copy its arrays into those of all rooms."""
        world = self._worlds[r]
        world.reset(self._rngs[r])
        room_state = world.compiled_state()
        if not self._allocated:
            self._state, self._allocated = self._allocate(room_state), True
        self._spaces[r] = room_state.handles.space
        for field, names in _ROOM_ARRAYS.items():
            for name in names:
                getattr(getattr(self._state, field), name)[r] = getattr(
                    getattr(room_state, field), name
                )
        self._state.controller[r] = room_state.controller
        self._state.poses[r] = room_state.poses
        self._steps[r], self._ended[r] = 0, False

    def _allocate(self, room_state: CompiledState) -> CompiledState:
        """Allocate the arrays of all rooms; equal numbers of objects give them equal shapes."""

        def repeat(array: np.ndarray) -> np.ndarray:
            return np.zeros((self.num_envs, *array.shape), array.dtype)

        fields: dict[str, Any] = {}
        for field, names in _ROOM_ARRAYS.items():
            value = getattr(room_state, field)
            fields[field] = value._replace(**{name: repeat(getattr(value, name)) for name in names})
        fields["controller"] = repeat(room_state.controller)
        fields["poses"] = repeat(room_state.poses)
        return room_state._replace(**fields)
