"""SC-experiments in Flatland under noise, each with its control: the same order twice.

Experiment i has the same start, sequence and permutation at all levels and under both protocols.
"""

from __future__ import annotations

import pandas as pd

from ....adapters.noise import NoisyWorld
from ....scp.distances import mean_squared_error
from ....scp.experiment import compare_orders, orders_of_dof
from ....scp.return_protocol import compare_legs, play_trial
from ....scp.world import Snapshot, World
from ....seeding import generator, seed_for
from ....storage.columns import FLOAT, TEXT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shards, table
from ...flatland.builders import DOFS
from ..builders import build_world, reset_free, world_settings
from ..columns import DOF, EXPERIMENT
from ..noise import noise_levels, noise_runs

NOISE = (
    Column("noise", TEXT, "", "sensor, actuator or reset", key=True),
    Column("protocol", TEXT, "", "reset or return", key=True),
    Column(
        "level", FLOAT, "1",
        "standard deviation: of a colour, of a motion as a share of it, or of every coordinate of "
        "the start pose in actions of 1",
        key=True,
    ),
)  # fmt: skip


def _settings(config: Config, run: str) -> object:
    noise = reset_free(config).noise
    return [world_settings(config, noise.world), noise_levels(config, noise_runs(config)[run])]


def play_noisy(
    world: World, start: Snapshot, seed: int, length: int, rest_steps: int, k: int, protocol: str
) -> tuple[float, float]:
    """Distances of the two orders, and of the same order twice."""
    sequence, permuted = orders_of_dof(world, seed, length, k)
    if protocol == "reset":
        orders = compare_orders(world, start, sequence, permuted, rest_steps)
        control = compare_orders(world, start, permuted, permuted, rest_steps)
        return mean_squared_error(*orders), mean_squared_error(*control)
    world.restore(start)
    legs = play_trial(world, sequence, permuted, rest_steps, come_back=False)
    return compare_legs(legs, mean_squared_error)[:2]


@table(
    title="SC-experiments under noise",
    columns=(
        *NOISE,
        DOF,
        EXPERIMENT,
        Column("distance", FLOAT, "squared 8-bit colour", "distance of the two orders"),
        Column("control", FLOAT, "squared 8-bit colour", "distance of the same order twice"),
    ),
    shards=Shards(
        runs=lambda config: {
            name: reset_free(config).noise.experiments for name in noise_runs(config)
        },
        settings=_settings,
        per_shard=lambda config: reset_free(config).lives_per_job,
    ),
    expected=lambda config: Expected(
        ("noise", "protocol"),
        {
            tuple(run): len(DOFS)
            * reset_free(config).noise.experiments
            * len(noise_levels(config, run))
            for run in noise_runs(config).values()
        },
    ),
)
def reset_free_noise_experiments(config: Config, run: str) -> Batched:
    """Play the experiments of one kind of noise under one protocol."""
    chosen, noise = noise_runs(config)[run], reset_free(config).noise
    inner = build_world(config, noise.world)
    length, rest_steps = config.flatland.sequence_length, config.flatland.rest_steps

    def compute(start: int, stop: int) -> pd.DataFrame:
        rows = []
        for i in range(start, stop):
            seed = seed_for(config.seed, "reset-free noise", i)
            for level in noise_levels(config, chosen):
                world = NoisyWorld(inner, **{chosen.noise: level})
                world.reset(generator(seed, "situation"))
                situation = world.snapshot()
                for k, dof in enumerate(world.dofs):
                    distances = play_noisy(
                        world, situation, seed, length, rest_steps, k, chosen.protocol
                    )
                    rows.append((*chosen, level, dof.name, i, *distances))
        return pd.DataFrame(rows, columns=reset_free_noise_experiments.column_names)

    return Batched(compute, size=25)
