"""The room and the agent that the configuration names."""

from __future__ import annotations

from ...errors import ConfigError
from ...seeding import generator
from ...worlds.flatland.agent import Polyphemus
from ...worlds.flatland.room import PlacementError, Room, draw_situation
from ...worlds.flatland.world import FlatlandWorld
from ..config import Config
from ..loading import joint_range
from .config import FlatlandConfig


def flatland_agent(config: FlatlandConfig, agent: str) -> Polyphemus:
    """Polyphemus as flatland.agents.`agent` describes it."""
    settings = config.agents[agent]
    return Polyphemus(
        arm_length=settings.arm_length,
        longitudinal_speed=settings.longitudinal_speed,
        angular_speed=settings.angular_speed,
        joint_range=joint_range(settings),
    )


def flatland_room(config: FlatlandConfig, world: str) -> Room:
    """The room that flatland.worlds.`world` describes."""
    settings = config.worlds[world]
    return Room(
        width=settings.width,
        height=settings.height,
        walls=settings.walls,
        things=settings.objects,
        start_margin=settings.start_margin,
        path_speed=settings.path_speed,
    )


def flatland_world(config: FlatlandConfig, world: str, agent: str) -> FlatlandWorld:
    """The agent in the room, both by name."""
    return FlatlandWorld(flatland_room(config, world), flatland_agent(config, agent))


TRIED = 10


def check_rooms(config: Config) -> None:
    """Raise ConfigError when an agent or its room's things do not fit into the room, by drawing a few situations of every agent and world in use."""
    flatland = config.flatland
    used = {(run.world, run.agent) for run in flatland.runs()} | {
        (world, flatland.reference.agent) for world in flatland.commutation_worlds()
    }
    for world, agent in sorted(used):
        try:
            for i in range(TRIED):
                draw_situation(
                    flatland_room(flatland, world),
                    flatland_agent(flatland, agent),
                    generator(config.seed, "check", world, agent, i),
                )
        except PlacementError as error:
            raise ConfigError(
                f"config: flatland.worlds.{world} with flatland.agents.{agent}: {error}"
            ) from None
