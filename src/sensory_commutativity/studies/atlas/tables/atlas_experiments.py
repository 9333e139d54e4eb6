"""SC-experiments with their controls, of every action of every environment."""

from __future__ import annotations

import pandas as pd

from ....measurement.controls import COLUMNS, play_with_controls
from ....seeding import seed_for
from ....storage.columns import FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shard, Shards, table
from ..builders import atlas, build_environment, environments
from ..columns import ACTION, ENVIRONMENT


def _settings(config: Config, run: str) -> object:
    return [environments(config)[run]]


def _expected(config: Config) -> Expected:
    return Expected(("environment",), {(name,): None for name in environments(config)})


def _expected_shard(config: Config, shard: Shard) -> Expected:
    rows = {(shard.run, i): None for i in range(shard.start, shard.stop)}
    return Expected(("environment", "experiment"), rows)


@table(
    title="SC-experiments in standard environments",
    columns=(
        ENVIRONMENT,
        ACTION,
        Column("experiment", INT, "1", "number of the start situation", key=True),
        Column("control", TEXT, "", "how actions became commands"),
        Column("way", TEXT, "", "how the state was restored"),
        *(Column(name, FLOAT, "1", text, nullable=True) for name, text in COLUMNS.items()),
    ),
    shards=Shards(
        runs=lambda config: {
            name: environment.starts or atlas(config).starts
            for name, environment in environments(config).items()
        },
        settings=_settings,
        per_shard=lambda config: atlas(config).starts_per_job,
    ),
    expected=_expected,
    expected_shard=_expected_shard,
)
def atlas_experiments(config: Config, run: str) -> Batched:
    """Play the SC-experiments of one environment."""
    settings = environments(config)[run]
    world = build_environment(settings)

    def compute(start: int, stop: int) -> pd.DataFrame:
        frames = []
        for i in range(start, stop):
            rows = play_with_controls(
                world, seed_for(config.seed, "atlas", run, i), settings.length, world.distance,
                settings.rest_steps, i,
            )  # fmt: skip
            frame = pd.DataFrame(rows, columns=list(COLUMNS))
            frame.insert(0, "environment", run)
            frame.insert(1, "action", [dof.name for dof in world.dofs])
            frame.insert(2, "experiment", i)
            frame.insert(3, "control", world.control.name)
            frame.insert(4, "way", world.exactness[-1].way)
            frames.append(frame)
        return pd.concat(frames, ignore_index=True)

    return Batched(compute, size=5)
