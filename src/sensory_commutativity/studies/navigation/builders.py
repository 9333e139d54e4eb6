"""The navigation task that the configuration describes, and the action spaces that the measured SCPs make of it."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd
from gymnasium.vector import AutoresetMode

from ...errors import ConfigError
from ...navigation.action_spaces import ScaledActions, Scp, action_scales, scp_of
from ...navigation.task import NavigationEnv, NavigationVectorEnv, Zone, room_with_zones
from ...seeding import generator, seed_for
from ...worlds.flatland.agent import Polyphemus
from ...worlds.flatland.room import PlacementError, Room, draw_situation
from ..config import Config
from ..flatland.builders import TRIED, flatland_agent, flatland_room


def task_parts(config: Config) -> tuple[Room, tuple[Zone, ...], Polyphemus]:
    """Room, zones and agent of the task."""
    navigation = config.navigation
    zones = tuple(Zone(zone.x, zone.y, zone.radius, zone.reward) for zone in navigation.zones)
    return (
        flatland_room(config.flatland, navigation.world),
        zones,
        flatland_agent(config.flatland, navigation.agent),
    )


def navigation_environment(config: Config, render_mode: str | None = None) -> NavigationEnv:
    """The task in one room, with the whole action space."""
    room, zones, agent = task_parts(config)
    return NavigationEnv(room, zones, agent, config.navigation.max_episode_steps, render_mode)


def navigation_rooms(config: Config, n: int, scales: Mapping[str, float]) -> ScaledActions:
    """The task in `n` rooms; `scales` (degree of freedom -> scale, in the order of the actions) make the action space.

    An ended episode is reset in the same step.
    """
    room, zones, agent = task_parts(config)
    rooms = NavigationVectorEnv(
        n, room, zones, agent, config.navigation.max_episode_steps, AutoresetMode.SAME_STEP
    )
    return ScaledActions(rooms, list(scales.values()))


def measured_scp(config: Config, scp_table: pd.DataFrame) -> dict[str, float]:
    """Degree of freedom -> SCP of the agent that learns, from a table that the workflow measured: flatland_scp or navigation_scp. Raises ScpError."""
    flatland, navigation = config.flatland, config.navigation
    dofs = [dof.name for dof in flatland_agent(flatland, navigation.agent).dofs]
    return scp_of(scp_table, dofs, navigation.scp_world, navigation.agent, flatland.sequence_length)


def scales_of_run(config: Config, scp: Scp, action_space: str, seed: int) -> dict[str, float]:
    """Degree of freedom -> scale of the action space in the run `seed`."""
    return action_scales(
        action_space,
        scp,
        generator(seed_for(config.seed, "navigation", action_space, seed), "half"),
    )


def evaluation_seeds(config: Config) -> list[int]:
    """Seeds of the evaluation's episodes, the same for every run."""
    return [
        seed_for(config.seed, "navigation", "evaluation", i)
        for i in range(config.navigation.evaluation_episodes)
    ]


def check_navigation(config: Config) -> None:
    """Raise ConfigError when the agent finds no place to start outside the zones."""
    room, zones, agent = task_parts(config)
    try:
        for i in range(TRIED):
            draw_situation(
                room_with_zones(room, zones),
                agent,
                generator(config.seed, "check", "navigation", i),
            )
    except PlacementError as error:
        raise ConfigError(
            f"config: navigation.zones leave too little room to start: {error}"
        ) from None
