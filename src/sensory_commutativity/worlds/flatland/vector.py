"""Many Flatland rooms stepped in one process: a compiled loop over rooms, behind Gymnasium's vector interface."""

from __future__ import annotations

from numbers import Integral
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ...compiled import njit
from . import chipmunk
from .agent import Polyphemus
from .control import Paths, Wiring, advance
from .environment import MAX_EPISODE_STEPS, action_space, observation_space
from .eye import Scene
from .room import Room
from .world import FlatlandWorld, Parts


@njit()
def advance_rooms(
    step_space,
    read_body,
    write_body,
    spaces,
    wiring,
    body,
    paths,
    scene,
    inner,
    pose,
    actions,
    rooms,
    skip,
    seen,
):
    """One step of `rooms`; arguments as for :func:`.control.advance` with a first dimension over all rooms, but `body`, which they share.

    `skip`, bool (all rooms,), marks rooms that are only looked at.
    """
    for r in rooms:
        one_wiring = Wiring(
            spaces[r], wiring.links[r], wiring.movers[r], wiring.bodies[r],
            wiring.state_channel, wiring.state, wiring.state_cursor,
            wiring.force_channel, wiring.force, wiring.force_cursor,
            wiring.velocity_channel, wiring.velocity, wiring.velocity_cursor,
        )  # fmt: skip
        one_paths = Paths(paths.corners[r], paths.path[r], paths.phase[r], paths.speed)
        one_scene = Scene(
            scene.rays, scene.field_of_view, scene.view_range,
            scene.outlines[r], scene.vertices[r], scene.radius[r], scene.colour[r], scene.walls, scene.wall_colour,
        )  # fmt: skip
        first = r + 1 if skip[r] else r
        advance(
            step_space, read_body, write_body, one_wiring, body, one_paths, one_scene,
            inner[r], pose[r], actions[first : r + 1], False, seen[r : r + 1],
        )  # fmt: skip


class FlatlandVectorEnv(VectorEnv):
    """`num_envs` rooms; each gives what a :class:`.environment.FlatlandEnv` seeded with its own seed would give, bit for bit.

    Parameters
    ----------
    num_envs : int
    room, agent : Room, Polyphemus
    max_episode_steps : int
        Episodes are truncated after so many steps.
    autoreset_mode : AutoresetMode
        ``NEXT_STEP``: a room whose episode has ended is reset by the next step, whose action for it is ignored. ``SAME_STEP``: it is reset at
        once; the step gives the first observation of the new episode, and the last one of the old in ``infos["final_obs"]``.
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
        self.single_action_space, self.single_observation_space = (
            action_space(agent),
            observation_space(agent),
        )
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._rngs: list[np.random.Generator] = []
        self._seen = np.zeros((num_envs, agent.pixels, 3), np.uint8)
        self._steps = np.zeros(num_envs, np.int64)
        self._ended = np.zeros(num_envs, bool)
        self._stacked = False

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Reset all rooms. With an integer seed, room i gets seed + i; without a seed the rooms' generators go on."""
        if isinstance(seed, Integral):
            seed = [int(seed) + i for i in range(self.num_envs)]
        if seed is not None or not self._rngs:
            old = self._rngs
            given = seed if seed is not None else [None] * self.num_envs
            if len(given) != self.num_envs:
                raise ValueError(
                    f"{self.num_envs} rooms need {self.num_envs} seeds, got {len(given)}"
                )
            self._rngs = [
                old[i] if old and s is None else seeding.np_random(s)[0]
                for i, s in enumerate(given)
            ]
        self._reset_rooms(np.arange(self.num_envs))
        return self._seen.copy(), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One step of every room: observations, rewards, terminations, truncations, infos."""
        if not self._stacked:
            raise RuntimeError("the rooms have no situation yet: call reset() first")
        actions = np.asarray(actions, np.float64)
        if actions.shape != self.action_space.shape:
            raise ValueError(
                f"actions must have the shape {self.action_space.shape}, got {actions.shape}"
            )
        if not np.isfinite(actions).all():
            raise ValueError("an action holds a value that is not finite; actions lie in [-1, 1]")
        resetting = self._ended.copy()  # none with SAME_STEP
        for r in np.flatnonzero(resetting):
            self._reset_room(r)
        self._steps[~resetting] += 1
        self._advance(actions, np.arange(self.num_envs), resetting)
        rewards, terminated = self._judge()
        terminated &= ~resetting
        truncated = (self._steps >= self.max_episode_steps) & ~terminated
        self._ended = terminated | truncated
        infos: dict[str, Any] = {}
        for r in np.flatnonzero(self._ended):
            last = self._last_info(r)
            told = (
                {"final_obs": self._seen[r].copy(), "final_info": last} if self._same_step else last
            )
            infos = self._add_info(infos, told, r)
        if self._same_step and self._ended.any():
            self._reset_rooms(np.flatnonzero(self._ended))
        return self._seen.copy(), np.where(resetting, 0.0, rewards), terminated, truncated, infos

    def _judge(self) -> tuple[np.ndarray, np.ndarray]:
        """Rewards, float64, and whether the episode ends by itself, bool, of every room as it is now; tasks override this."""
        return np.zeros(self.num_envs), np.zeros(self.num_envs, bool)

    def _last_info(self, r: int) -> dict[str, Any]:
        """What the single environment's info holds at the end of an episode, of room `r` as it is now; tasks override this."""
        return {}

    def _advance(self, actions: np.ndarray, rooms: np.ndarray, skip: np.ndarray) -> None:
        advance_rooms(
            chipmunk.STEP, chipmunk.READ_BODY, chipmunk.WRITE_BODY, self._spaces, self._wiring, self._body, self._paths, self._scene,
            self._inner, self._pose, actions, rooms, skip, self._seen,
        )  # fmt: skip

    def _reset_rooms(self, rooms: np.ndarray) -> None:
        """Draw new situations for `rooms` and look at them."""
        for r in rooms:
            self._reset_room(r)
        self._advance(np.zeros(self.action_space.shape), rooms, np.ones(self.num_envs, bool))

    def _reset_room(self, r: int) -> None:
        """Draw a new situation for room `r` and copy what the compiled loop needs of it into the stacks."""
        world = self._worlds[r]
        world.reset(self._rngs[r])
        parts = world.parts()
        if not self._stacked:
            self._stack(parts)
        self._spaces[r] = parts.wiring.space
        for stack, one, names in self._stacks(parts):
            for name in names:
                getattr(stack, name)[r] = getattr(one, name)
        self._inner[r], self._pose[r] = parts.inner, parts.pose
        self._steps[r], self._ended[r] = 0, False

    def _stack(self, parts: Parts) -> None:
        """Make room for the arrays of all rooms; all have the same number of things, hence the same shapes."""

        def stack(array: np.ndarray) -> np.ndarray:
            return np.zeros((self.num_envs, *array.shape), array.dtype)

        self._spaces = np.zeros(self.num_envs, np.uint64)
        self._wiring, self._paths, self._scene = (
            one._replace(**{name: stack(getattr(one, name)) for name in names})
            for _, one, names in self._stacks(parts, new=True)
        )
        self._body, self._inner, self._pose = parts.body, stack(parts.inner), stack(parts.pose)
        self._stacked = True

    def _stacks(
        self, parts: Parts, new: bool = False
    ) -> tuple[tuple[Any, Any, tuple[str, ...]], ...]:
        """(stack, its part of one room, the names of the arrays that each room has of its own)."""
        wiring, paths, scene = (
            (None, None, None) if new else (self._wiring, self._paths, self._scene)
        )
        return (
            (wiring, parts.wiring, ("links", "movers", "bodies")),
            (paths, parts.paths, ("corners", "path", "phase")),
            (scene, parts.scene, ("outlines", "vertices", "radius", "colour")),
        )
