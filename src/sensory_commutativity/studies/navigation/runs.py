"""Training runs: their names, what they depend on, and when they are evaluated."""

from __future__ import annotations

from ..config import Config
from ..declarations import Shards
from .builders import settings_of_run


def training_runs(config: Config) -> dict[str, tuple[str, int]]:
    """Action space and seed of all training runs by name, ``ACTION_SPACE.SEED``."""
    return {
        f"{action_space}.{seed}": (action_space, seed)
        for action_space, seed in config.navigation.runs
    }


def evaluation_steps(config: Config) -> list[int]:
    """Environment steps of training before each evaluation of a run."""
    navigation = config.navigation
    segment = navigation.steps // navigation.checkpoints
    return [segment * (k + 1) for k in range(navigation.checkpoints)]


def _settings(config: Config, run: str) -> object:
    # The scales of the action space follow from the name of the run and the measured SCPs.
    return [settings_of_run(config, scales={}), config.flatland.sequence_length]


TRAINING = Shards(runs=lambda config: dict.fromkeys(training_runs(config), 1), settings=_settings)
"""A shard for every training run."""
