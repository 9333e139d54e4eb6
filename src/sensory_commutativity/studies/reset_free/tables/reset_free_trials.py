"""Trials of the return protocol in Flatland, each beside the experiment with a restored start.

In a run with one trial per reset, every degree of freedom starts from the same situation. In a
longer life nothing is put back: the agent wanders between trials, and degrees of freedom are tried
one after the other. A snapshot serves the truth alone, after which the world goes on from it.
"""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from ....scp.distances import mean_squared_error
from ....scp.experiment import orders_of_dof, play_order
from ....scp.return_protocol import ReturnDistances, compare_legs, play_trial, wander
from ....scp.world import World
from ....seeding import generator, seed_for
from ....storage.columns import INT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shards, table
from ...flatland.builders import DOFS
from ..builders import build_world, reset_free, trial_runs, world_settings
from ..columns import DISTANCES, DOF, EXPERIMENT, WORLD

WANDER = 50
"""Random actions between two trials of a life. Chosen: as many as a sequence has."""


def play_with_truth(
    world: World, seed: int, length: int, rest_steps: int, k: int, come_back: bool
) -> tuple[float, ReturnDistances]:
    """A trial of degree of freedom `k` from the present situation, and the true distance.

    The first order of the experiment is the first leg of the trial: both begin at the same start.
    """
    start = world.snapshot()
    sequence, permuted = orders_of_dof(world, seed, length, k)
    play_order(world, start, permuted, rest_steps)
    second = world.observe()
    world.restore(start)
    legs = play_trial(world, sequence, permuted, rest_steps, come_back=come_back)
    return mean_squared_error(legs.first, second), compare_legs(legs, mean_squared_error)


def play_life(
    world: World, seed: int, trials: int, length: int, rest_steps: int
) -> Iterator[tuple[int, str, float, ReturnDistances]]:
    """Yield the trials of one life: number, degree of freedom, true distance, distances."""
    world.reset(generator(seed, "situation"))
    start = world.snapshot()
    for j in range(trials):
        for k, dof in enumerate(world.dofs):
            trial = seed_for(seed, "trial", j) if trials > 1 else seed
            if trials > 1:
                wander(world, seed_for(trial, dof.name), WANDER)
            else:
                world.restore(start)
            found = play_with_truth(world, trial, length, rest_steps, k, come_back=trials > 1)
            yield j, dof.name, *found


def _settings(config: Config, run: str) -> object:
    chosen = trial_runs(config)[run]
    return [world_settings(config, chosen.world), chosen.trials]


@table(
    title="Trials of the return protocol in Flatland",
    columns=(
        WORLD,
        DOF,
        EXPERIMENT,
        Column("life", INT, "1", "number of the reset"),
        *DISTANCES,
    ),
    shards=Shards(
        runs=lambda config: {name: run.lives for name, run in trial_runs(config).items()},
        settings=_settings,
        per_shard=lambda config: max(1, reset_free(config).lives_per_job),
    ),
    expected=lambda config: Expected(
        ("world",),
        {(name,): run.experiments * len(DOFS) for name, run in trial_runs(config).items()},
    ),
)
def reset_free_trials(config: Config, run: str) -> Batched:
    """Play the trials of one run; a unit is a life."""
    chosen = trial_runs(config)[run]
    world = build_world(config, chosen.world)
    length, rest_steps = config.flatland.sequence_length, config.flatland.rest_steps

    def compute(start: int, stop: int) -> pd.DataFrame:
        rows = []
        for life in range(start, stop):
            seed = seed_for(config.seed, "reset-free", run, life)
            for j, dof, truth, distances in play_life(
                world, seed, chosen.trials, length, rest_steps
            ):
                rows.append((run, dof, life * chosen.trials + j, life, truth, *distances))
        return pd.DataFrame(rows, columns=reset_free_trials.column_names)

    return Batched(compute, size=max(1, 100 // chosen.trials))
