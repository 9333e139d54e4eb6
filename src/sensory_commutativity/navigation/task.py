"""The navigation task: reach the goal, keep out of the dead zones (paper, section IV-B), alone and in many rooms at once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from ..worlds.flatland.agent import Polyphemus
from ..worlds.flatland.environment import FlatlandEnv
from ..worlds.flatland.room import Mark, Room
from ..worlds.flatland.vector import FlatlandVectorEnv

DEAD_COLOUR, GOAL_COLOUR = (
    (255, 40, 40),
    (40, 255, 40),
)  # chosen: pure colours that no wall, arm or thing has


@dataclass(frozen=True)
class Zone:
    """A disc on the floor that ends the episode when the agent's base touches it."""

    x: float  # units
    y: float  # units
    radius: float  # units, above 0
    reward: float  # above 0 for the goal, below 0 for a dead zone

    @property
    def is_goal(self) -> bool:
        return self.reward > 0


def room_with_zones(room: Room, zones: tuple[Zone, ...]) -> Room:
    """`room` with the zones as marks, so that the eye sees them and the agent starts outside them."""
    if not zones:
        raise ValueError(
            "the task needs at least one zone: nothing else ends an episode with a reward"
        )
    marks = tuple(
        Mark(zone.x, zone.y, zone.radius, GOAL_COLOUR if zone.is_goal else DEAD_COLOUR)
        for zone in zones
    )
    return replace(room, marks=marks)


def touched(zones: tuple[Zone, ...], base: np.ndarray, base_radius: float) -> np.ndarray:
    """Number of the first zone that each base touches, int64 (n,), or -1; `base` is float64 (n, 2), the bases' middles in units."""
    places = np.array([(zone.x, zone.y) for zone in zones])
    reach = np.array([zone.radius for zone in zones]) + base_radius
    touching = ((base[:, None] - places) ** 2).sum(-1) <= reach**2
    return np.where(touching.any(1), touching.argmax(1), -1)


class NavigationEnv(FlatlandEnv):
    """Polyphemus in a room with dead zones and a goal.

    Action Space and Observation Space
    ----------------------------------
    Those of :class:`~sensory_commutativity.worlds.flatland.environment.FlatlandEnv`. The zones are seen: dead zones red, the goal green.

    Rewards
    -------
    The reward of the zone that the base touches (paper: -20 for a dead zone, +50 for the goal), otherwise 0.

    Starting State
    --------------
    The agent at a random free place outside the zones, heading anywhere, at rest.

    Episode End
    -----------
    Terminates when the base touches a zone; truncated after `max_episode_steps`. ``info["is_success"]`` tells, at the end, whether it was the goal.

    Parameters
    ----------
    room, agent : Room, Polyphemus
    zones : tuple of Zone
    max_episode_steps : int
    render_mode : None or ``"rgb_array"``
    """

    def __init__(
        self,
        room: Room,
        zones: tuple[Zone, ...],
        agent: Polyphemus | None = None,
        max_episode_steps: int = 300,
        render_mode: str | None = None,
    ):
        super().__init__(room_with_zones(room, zones), agent, render_mode)
        self.zones, self.max_episode_steps = zones, max_episode_steps

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        self._steps = 0
        return super().reset(seed=seed, options=options)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        seen, *_ = super().step(action)
        self._steps += 1
        zone = int(touched(self.zones, self.world.poses()[:1, :2], self.world.agent.base_radius)[0])
        terminated = zone >= 0
        truncated = self._steps >= self.max_episode_steps and not terminated
        info = (
            {"is_success": terminated and self.zones[zone].is_goal}
            if terminated or truncated
            else {}
        )
        return seen, self.zones[zone].reward if terminated else 0.0, terminated, truncated, info


class NavigationVectorEnv(FlatlandVectorEnv):
    """Many rooms of :class:`NavigationEnv`, stepped by one compiled loop; each gives what the single environment would, bit for bit."""

    def __init__(
        self,
        num_envs: int,
        room: Room,
        zones: tuple[Zone, ...],
        agent: Polyphemus | None = None,
        max_episode_steps: int = 300,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
    ):
        super().__init__(
            num_envs, room_with_zones(room, zones), agent, max_episode_steps, autoreset_mode
        )
        self.zones = zones
        self._base_radius = (agent or Polyphemus()).base_radius
        self._rewards = np.array(
            [*(zone.reward for zone in zones), 0.0]
        )  # the last is for touching none

    def _judge(self) -> tuple[np.ndarray, np.ndarray]:
        self._zone = touched(self.zones, self._pose[:, 0, :2], self._base_radius)
        return self._rewards[self._zone], self._zone >= 0

    def _last_info(self, r: int) -> dict[str, Any]:
        return {"is_success": bool(self._zone[r] >= 0 and self.zones[self._zone[r]].is_goal)}
