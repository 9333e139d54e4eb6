"""The room and the agent that the configuration names."""

from __future__ import annotations

from ...config import FlatlandConfig, joint_range
from .agent import Polyphemus
from .room import Room
from .world import FlatlandWorld


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
        things=settings.things,
        start_margin=settings.start_margin,
        path_speed=settings.path_speed,
    )


def flatland_world(config: FlatlandConfig, world: str, agent: str) -> FlatlandWorld:
    """The agent in the room, both by name."""
    return FlatlandWorld(flatland_room(config, world), flatland_agent(config, agent))
