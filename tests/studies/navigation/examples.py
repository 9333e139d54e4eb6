"""Made-up learning curves."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd

from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import merge, validate
from sensory_commutativity.studies.navigation.tables.navigation_curves import navigation_curves

SPACES = ["full", "truncated", "adapted", "random-half", "inverse"]
SEEDS = [3, 1, 4, 15, 9, 2]
STEP, CHECKPOINTS = 2048, 5
ALPHA = 0.05


def with_spaces(config: Config, spaces: list[str], **navigation) -> Config:
    """Six runs of each of `spaces`, evaluated at five checkpoints with ten episodes."""
    changes = dict(
        action_spaces=spaces,
        seeds=SEEDS,
        steps=CHECKPOINTS * STEP,
        checkpoints=CHECKPOINTS,
        calibration_splits=51,
        evaluation_episodes=10,
        alpha=ALPHA,
        **navigation,
    )
    return validate(merge(config.model_dump(mode="json"), {"navigation": changes}))


def make_curves(config: Config, value: Callable[[str, int, int], float]) -> pd.DataFrame:
    """A table navigation_curves.

    Parameters
    ----------
    value : callable
        (action space, number of the run from 0, checkpoint from 1) -> mean return.
    """
    rows = [
        (space, seed, k * STEP, value(space, i, k), 0.5, 0.1, 50.0, 10)
        for space in config.navigation.action_spaces
        for i, seed in enumerate(SEEDS)
        for k in range(1, CHECKPOINTS + 1)
    ]
    return pd.DataFrame(rows, columns=navigation_curves.column_names)
