"""What the section reset_free names: runs, and worlds with noise."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...errors import ConfigError
from ..config import Config
from ..flatland.builders import flatland_world
from .config import ApartmentTrialsConfig, ImaginedConfig, ResetFreeConfig, TrialsConfig

if TYPE_CHECKING:
    from ...worlds.flatland.world import FlatlandWorld


def reset_free(config: Config) -> ResetFreeConfig:
    """The section reset_free. Raises ConfigError if the configuration has none."""
    if config.reset_free is None:
        raise ConfigError("config: reset_free is null; give it the section of config/config.yaml")
    return config.reset_free


def trial_runs(config: Config) -> dict[str, TrialsConfig]:
    """Runs of trials in Flatland by name; none without a section."""
    return dict(config.reset_free.flatland) if config.reset_free is not None else {}


def apartment_runs(config: Config) -> dict[str, ApartmentTrialsConfig]:
    """Runs of trials in apartments by name; none without a section."""
    return dict(config.reset_free.apartment) if config.reset_free is not None else {}


def imagined_runs(config: Config) -> dict[str, ImaginedConfig]:
    """Environments with a forward model by name; none without a section."""
    return dict(config.reset_free.imagined) if config.reset_free is not None else {}


def world_settings(config: Config, world: str) -> list[object]:
    """Everything that a trial in a world of Flatland depends on."""
    flatland, agent = config.flatland, reset_free(config).agent
    return [
        flatland.sequence_length, flatland.rest_steps, world, flatland.worlds[world], agent,
        flatland.agents[agent],
    ]  # fmt: skip


def build_world(config: Config, world: str) -> FlatlandWorld:
    """The agent of the section in a world of Flatland."""
    return flatland_world(config.flatland, world, reset_free(config).agent)
