"""SC-experiments of every degree of freedom of an agent in a world (paper, definition 3 and
section III-A).

Experiment i draws a start situation, from which every degree of freedom is tried, with a sequence
and a permutation of its own. Sequences of other lengths share the start situations.
"""

from __future__ import annotations

import pandas as pd

from ....scp.experiment import distances_per_dof
from ....seeding import seed_for
from ....storage.columns import INT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shard, Shards, table
from ..builders import DOFS, experiment_runs, flatland_world
from ..columns import AGENT, DISTANCE, DOF, LENGTH, SEED, WORLD
from ..config import Run


def _settings(config: Config, run: str) -> object:
    flatland, (world, agent, length, _) = config.flatland, experiment_runs(config)[run]
    return [length, flatland.rest_steps, world, flatland.worlds[world], agent,
            flatland.agents[agent]]  # fmt: skip


RUN = ("world", "agent", "length")


def _expected(config: Config) -> tuple[Expected, ...]:
    runs = config.flatland.runs()
    shards = [expected_units(run, 0, run.experiments) for run in runs]
    return Expected(RUN, {run[:3]: run.experiments * len(DOFS) for run in runs}), *(
        Expected(columns, {key: n for shard in shards for key, n in shard[k].counts.items()})
        for k, columns in enumerate(((*RUN, "experiment"), (*RUN, "dof")))
    )


def _expected_shard(config: Config, shard: Shard) -> tuple[Expected, ...]:
    return expected_units(experiment_runs(config)[shard.run], shard.start, shard.stop)


def expected_units(run: Run, start: int, stop: int) -> tuple[Expected, Expected]:
    """The rows of the experiments start <= i < stop of a run: every degree of freedom of each."""
    experiments = {(*run[:3], i): len(DOFS) for i in range(start, stop)}
    dofs = {(*run[:3], dof): stop - start for dof in DOFS}
    return Expected((*RUN, "experiment"), experiments), Expected((*RUN, "dof"), dofs)


@table(
    title="SC-experiments in Flatland",
    columns=(
        WORLD,
        AGENT,
        LENGTH,
        DOF,
        Column(
            "experiment", INT, "1",
            "number of the experiment; all degrees of freedom share its start situation", key=True,
        ),
        SEED,
        DISTANCE,
    ),
    shards=Shards(
        runs=lambda config: {
            name: run.experiments for name, run in experiment_runs(config).items()
        },
        settings=_settings,
        per_shard=lambda config: config.flatland.experiments_per_job,
    ),
    expected=_expected,
    expected_shard=_expected_shard,
)  # fmt: skip
def flatland_experiments(config: Config, run: str) -> Batched:
    """Play the SC-experiments of one agent in one world."""
    world, agent, length, _ = experiment_runs(config)[run]
    simulated = flatland_world(config.flatland, world, agent)

    def compute(start: int, stop: int) -> pd.DataFrame:
        rows = []
        for i in range(start, stop):
            seed = seed_for(config.seed, "flatland", world, agent, i)
            distances = distances_per_dof(
                simulated, seed, length, rest_steps=config.flatland.rest_steps
            )
            rows += [(world, agent, length, dof, i, seed, d) for dof, d in distances.items()]
        return pd.DataFrame(rows, columns=flatland_experiments.column_names)

    return Batched(compute)
