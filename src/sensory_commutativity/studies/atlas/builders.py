"""Environments of the atlas as worlds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import ConfigError
from ..config import Config
from .config import AtlasConfig, EnvironmentConfig

if TYPE_CHECKING:
    from ...adapters.gymnasium import GymnasiumWorld

GRIPPER, OBJECT = slice(6, 9), slice(9, 12)
"""Where Fetch's flattened observation holds the positions of the gripper and of the object, metres:
after the goals, achieved and desired."""
GAIN = 8.0
"""Actions per metre of distance in an approach. Chosen: full speed at 12 cm."""
OFFSET = 0.06
"""Metres beside the object at which an approach ends. Chosen: the gripper just misses it."""


def atlas(config: Config) -> AtlasConfig:
    """The section atlas. Raises ConfigError if the configuration has none."""
    if config.atlas is None:
        raise ConfigError("config: there is no section atlas; merge config/atlas.yaml over it")
    return config.atlas


def environments(config: Config) -> dict[str, EnvironmentConfig]:
    """The environments of the atlas by name; none without a section atlas."""
    return config.atlas.environments if config.atlas is not None else {}


def build_environment(settings: EnvironmentConfig) -> GymnasiumWorld:
    """The world that the settings describe."""
    from ...adapters.gymnasium import GymnasiumWorld
    from ...adapters.registry import make_environment

    return GymnasiumWorld(
        make_environment(settings.env_id),
        control=settings.control,
        snapshots=settings.snapshots,
        sensors=settings.sensors,
        avoid_stops=settings.avoid_stops,
        approach=approach_fetch if settings.approach == "fetch" else None,
    )


def approach_fetch(observation: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """An action that brings Fetch's gripper beside the object, from a side that the object's own
    place determines."""
    object_position = observation[OBJECT]
    angle = 1e4 * float(object_position[:2].sum())  # any side, and always the same one
    side = np.array([np.cos(angle), np.sin(angle), 0.0])
    error = object_position + OFFSET * side - observation[GRIPPER]
    return np.append(np.clip(GAIN * error, -1, 1) + 0.05 * rng.normal(size=3), 0.0)
