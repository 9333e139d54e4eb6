"""The navigation task: reach the goal, avoid the dead zones (paper, section IV-B).

It comes as a single environment and as a vector environment.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from ..worlds.flatland.agent import Polyphemus
from ..worlds.flatland.environment import MAX_EPISODE_STEPS, FlatlandEnv
from ..worlds.flatland.room import FloorZone, Room
from ..worlds.flatland.vector import FlatlandVectorEnv

# RGB. Chosen: pure colours that no wall, arm or object has.
DEAD_COLOUR = (255, 40, 40)
GOAL_COLOUR = (40, 255, 40)


@dataclass(frozen=True)
class RewardZone:
    """A disc on the floor; the episode ends when the agent's base touches it."""

    x: float  # of the centre, units
    y: float  # of the centre, units
    radius: float  # units, above 0
    reward: float  # above 0 for the goal, below 0 for a dead zone

    @property
    def is_goal(self) -> bool:
        return self.reward > 0


@dataclass(frozen=True)
class NavigationTask:
    """What defines the task.

    Attributes
    ----------
    room : Room
    zones : tuple of RewardZone
    agent : Polyphemus
    max_episode_steps : int
        Time limit of an episode, steps.
    """

    room: Room
    zones: tuple[RewardZone, ...]
    agent: Polyphemus = field(default_factory=Polyphemus)
    max_episode_steps: int = MAX_EPISODE_STEPS

    def make_env(self, render_mode: str | None = None) -> NavigationEnv:
        """Create a single environment."""
        return NavigationEnv(self.room, self.zones, self.agent, self.max_episode_steps, render_mode)

    def make_vector_env(
        self, num_envs: int, autoreset_mode: AutoresetMode = AutoresetMode.SAME_STEP
    ) -> NavigationVectorEnv:
        """Create a vector environment; by default in the mode that Stable-Baselines3 needs."""
        return NavigationVectorEnv(
            num_envs, self.room, self.zones, self.agent, self.max_episode_steps, autoreset_mode
        )


def room_with_zones(room: Room, zones: tuple[RewardZone, ...]) -> Room:
    """Add the zones to a room: the agent sees them and starts outside them.

    Raises ValueError if there are none, because no episode could end with a reward.
    """
    if not zones:
        raise ValueError("the task needs at least one zone")
    floor_zones = tuple(
        FloorZone(zone.x, zone.y, zone.radius, GOAL_COLOUR if zone.is_goal else DEAD_COLOUR)
        for zone in zones
    )
    return replace(room, zones=floor_zones)


def find_touched_zones(
    zones: tuple[RewardZone, ...], base: np.ndarray, base_radius: float
) -> np.ndarray:
    """Find the first zone that each base touches.

    Parameters
    ----------
    zones : tuple of RewardZone
    base : float64 (n, 2)
        Centres of the bases, units.
    base_radius : float
        Units.

    Returns
    -------
    int64 (n,)
        Index of the zone, or -1.
    """
    centres = np.array([(zone.x, zone.y) for zone in zones])
    reach = np.array([zone.radius for zone in zones]) + base_radius
    touching = ((base[:, None] - centres) ** 2).sum(-1) <= reach**2  # (n, n_zones)
    return np.where(touching.any(1), touching.argmax(1), -1)


class NavigationEnv(FlatlandEnv):
    """Polyphemus in a room with dead zones and a goal.

    Action Space and Observation Space
    ----------------------------------
    Those of :class:`~sensory_commutativity.worlds.flatland.environment.FlatlandEnv`. The agent
    sees dead zones in red and the goal in green.

    Rewards
    -------
    The reward of the zone that the base touches (paper: -20 for a dead zone, +50 for the goal),
    otherwise 0.

    Starting State
    --------------
    The agent at rest, at a random free position outside the zones, with a random heading.

    Episode End
    -----------
    Terminates when the base touches a zone; truncated after `max_episode_steps`. In the last step,
    ``info["is_success"]`` tells whether the agent reached the goal.

    Parameters
    ----------
    room, agent : Room, Polyphemus
    zones : tuple of RewardZone
    max_episode_steps : int
    render_mode : None or ``"rgb_array"``
    """

    def __init__(
        self,
        room: Room,
        zones: tuple[RewardZone, ...],
        agent: Polyphemus | None = None,
        max_episode_steps: int = MAX_EPISODE_STEPS,
        render_mode: str | None = None,
    ):
        super().__init__(room_with_zones(room, zones), agent, render_mode)
        self.zones = zones
        self.max_episode_steps = max_episode_steps

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        self._steps = 0
        return super().reset(seed=seed, options=options)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        observation, *_ = super().step(action)
        self._steps += 1
        base = self.world.poses()[:1, :2]
        zone = int(find_touched_zones(self.zones, base, self.world.agent.base_radius)[0])
        terminated = zone >= 0
        truncated = self._steps >= self.max_episode_steps and not terminated
        reward = self.zones[zone].reward if terminated else 0.0
        info: dict[str, Any] = {}
        if terminated or truncated:
            info["is_success"] = terminated and self.zones[zone].is_goal
        return observation, reward, terminated, truncated, info


class NavigationVectorEnv(FlatlandVectorEnv):
    """Many :class:`NavigationEnv`, stepped by one compiled loop; the results are bit-identical.

    Parameters are those of :class:`NavigationEnv` and
    :class:`~sensory_commutativity.worlds.flatland.vector.FlatlandVectorEnv`.
    """

    def __init__(
        self,
        num_envs: int,
        room: Room,
        zones: tuple[RewardZone, ...],
        agent: Polyphemus | None = None,
        max_episode_steps: int = MAX_EPISODE_STEPS,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
    ):
        super().__init__(
            num_envs, room_with_zones(room, zones), agent, max_episode_steps, autoreset_mode
        )
        self.zones = zones
        self._base_radius = (agent or Polyphemus()).base_radius
        # The last element is the reward for index -1: no zone.
        self._rewards = np.array([*(zone.reward for zone in zones), 0.0])

    def _rewards_and_terminations(self) -> tuple[np.ndarray, np.ndarray]:
        self._zone = find_touched_zones(self.zones, self._state.poses[:, 0, :2], self._base_radius)
        return self._rewards[self._zone], self._zone >= 0

    def _final_info(self, r: int) -> dict[str, Any]:
        return {"is_success": bool(self._zone[r] >= 0 and self.zones[self._zone[r]].is_goal)}
