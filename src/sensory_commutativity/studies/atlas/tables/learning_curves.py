"""Learning curves of PPO with the planar arm, in every action space."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shards, table
from ..builders import atlas
from ..columns import ACTION_SPACE


def _expected(config: Config) -> Expected:
    if config.atlas is None:
        return Expected(("action_space", "seed"), {})
    settings = config.atlas.learning
    rows = {
        (space, seed): settings.evaluations + 1
        for space in settings.action_spaces
        for seed in range(settings.seeds)
    }
    return Expected(("action_space", "seed"), rows)


def _runs(config: Config) -> dict[str, int]:
    if config.atlas is None:
        return {}
    return dict.fromkeys(config.atlas.learning.action_spaces, config.atlas.learning.seeds)


@table(
    title="Learning curves of the planar arm",
    columns=(
        ACTION_SPACE,
        Column("seed", INT, "1", "number of the training run", key=True),
        Column("step", INT, "steps", "environment steps of training before the evaluation",
               key=True),
        Column("episode_return", FLOAT, "reward", "mean return of the episodes"),
        Column("displacement", FLOAT, "m", "mean distance by which the puck was pushed"),
    ),
    inputs=["learning_scp"],
    shards=Shards(
        runs=_runs,
        settings=lambda config, run: [atlas(config).learning, run],
        per_shard=lambda config: atlas(config).runs_per_job,
    ),
    expected=_expected,
)  # fmt: skip
def learning_curves(scp: pd.DataFrame, config: Config, run: str) -> Batched:
    """Train with one action space."""
    from ..learning import train_curve

    settings = atlas(config).learning
    scps = dict(zip(scp["dof"], scp["scp"], strict=True))

    def compute(start: int, stop: int) -> pd.DataFrame:
        frames = []
        for seed in range(start, stop):
            curve = train_curve(settings, run, seed, scps, config.seed)
            curve.insert(0, "action_space", run)
            curve.insert(1, "seed", seed)
            frames.append(curve)
        return pd.concat(frames, ignore_index=True)

    return Batched(compute, size=1)
