"""What the configuration of Flatland names: agents, rooms, worlds, and runs of experiments."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...errors import ConfigError
from ...seeding import generator
from ...worlds.flatland.agent import Polyphemus
from ..config import Config
from .config import FlatlandConfig, Run

if TYPE_CHECKING:
    from ...worlds.flatland.room import Room
    from ...worlds.flatland.world import FlatlandWorld

DOFS = tuple(dof.name for dof in Polyphemus().dofs)
"""Names of the degrees of freedom of every agent, in the order of the actions."""
CHECKED_SITUATIONS = 10
"""Start situations that are drawn of every agent and world to check a configuration. Chosen."""


def experiment_runs(config: Config) -> dict[str, Run]:
    """All runs of SC-experiments by name, ``WORLD.AGENT.LENGTH``."""
    return {f"{run.world}.{run.agent}.{run.length}": run for run in config.flatland.runs()}


def flatland_agent(config: FlatlandConfig, agent: str) -> Polyphemus:
    """Polyphemus as flatland.agents.`agent` describes it."""
    settings = config.agents[agent]
    degrees = settings.joint_range_degrees
    return Polyphemus(
        arm_length=settings.arm_length,
        longitudinal_speed=settings.longitudinal_speed,
        angular_speed=settings.angular_speed,
        joint_range=math.inf if degrees is None else math.radians(degrees),
    )


def flatland_room(config: FlatlandConfig, world: str) -> Room:
    """The room that flatland.worlds.`world` describes."""
    from ...worlds.flatland.room import Room

    settings = config.worlds[world]
    return Room(
        width=settings.width,
        height=settings.height,
        walls=settings.walls,
        objects=settings.objects,
        start_margin=settings.start_margin,
        path_speed=settings.path_speed,
    )


def flatland_world(config: FlatlandConfig, world: str, agent: str) -> FlatlandWorld:
    """The agent in the room, both by name."""
    from ...worlds.flatland.world import FlatlandWorld  # imports numba and pymunk

    return FlatlandWorld(flatland_room(config, world), flatland_agent(config, agent))


def check_rooms(config: Config) -> None:
    """Check that agents and objects fit into their rooms, by drawing a few start situations.

    Raises
    ------
    ConfigError
    """
    from ...worlds.flatland.room import PlacementError, sample_situation

    flatland = config.flatland
    used = {(run.world, run.agent) for run in flatland.runs()}
    used |= {(world, flatland.reference.agent) for world in flatland.commutation_worlds()}
    for world, agent in sorted(used):
        try:
            for i in range(CHECKED_SITUATIONS):
                sample_situation(
                    flatland_room(flatland, world),
                    flatland_agent(flatland, agent),
                    generator(config.seed, "check", world, agent, i),
                )
        except PlacementError as error:
            raise ConfigError(
                f"config: flatland.worlds.{world} with flatland.agents.{agent}: {error}"
            ) from None
