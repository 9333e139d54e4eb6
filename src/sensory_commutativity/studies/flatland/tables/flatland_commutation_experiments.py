"""Philipona's conjecture, tried (paper, section II-C): does a sequence of one degree of freedom
commute with one of another?

From one start, h (of a) then g (of b) is played, and g then h. Each unordered pair is played once.
With a = b, h and g are two different sequences of the same degree of freedom.

The conjecture is tried in the reference world and in a settled one, in which nothing moves by
itself and pushed objects have time to come to rest: objects that move by themselves go on moving
while the agent waits.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

import pandas as pd

from ....scp.distances import mean_squared_error
from ....scp.experiment import commutation_experiment
from ....scp.sequences import sample_sequence
from ....seeding import generator, seed_for
from ....storage.columns import INT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shard, Shards, table
from ..builders import DOFS, flatland_world
from ..columns import DISTANCE, DOF_A, DOF_B, SEED, WORLD


def _settings(config: Config, world: str) -> object:
    flatland = config.flatland
    agent = flatland.reference.agent
    return [flatland.sequence_length, flatland.commutation_worlds()[world], world,
            flatland.worlds[world], agent, flatland.agents[agent]]  # fmt: skip


def _expected_shard(config: Config, shard: Shard) -> tuple[Expected, ...]:
    pairs, units = list(combinations_with_replacement(DOFS, 2)), range(shard.start, shard.stop)
    return (
        Expected(("world", "experiment"), {(shard.run, i): len(pairs) for i in units}),
        Expected(("world", "dof_a", "dof_b"), {(shard.run, *pair): len(units) for pair in pairs}),
    )


@table(
    title="Commutation experiments on pairs of degrees of freedom",
    columns=(
        WORLD,
        DOF_A,
        DOF_B,
        Column(
            "experiment", INT, "1", "number of the experiment; all pairs share its start situation",
            key=True,
        ),
        SEED,
        DISTANCE,
    ),
    shards=Shards(
        runs=lambda config: dict.fromkeys(
            config.flatland.commutation_worlds(), config.flatland.commutation.experiments
        ),
        settings=_settings,
        per_shard=lambda config: config.flatland.commutation_per_job,
    ),
    shards_only=True,
    expected_shard=_expected_shard,
)  # fmt: skip
def flatland_commutation_experiments(config: Config, world: str) -> Batched:
    """Play every unordered pair of degrees of freedom in one world."""
    flatland, rest_steps = config.flatland, config.flatland.commutation_worlds()[world]
    agent, length = flatland.reference.agent, flatland.sequence_length
    simulated = flatland_world(flatland, world, agent)
    n = len(simulated.dofs)

    def sequence(seed: int, k: int, which: str):
        rng = generator(seed, which, simulated.dofs[k].name)
        return sample_sequence(rng, length, k, n)

    def compute(start: int, stop: int) -> pd.DataFrame:
        rows = []
        for i in range(start, stop):
            seed = seed_for(config.seed, "commutation", world, agent, i)
            simulated.reset(generator(seed, "situation"))
            initial = simulated.snapshot()
            first = [sequence(seed, k, "first") for k in range(n)]
            for a, b in combinations_with_replacement(range(n), 2):
                g = sequence(seed, b, "second") if a == b else first[b]
                outcome = commutation_experiment(simulated, initial, first[a], g, rest_steps)
                names = simulated.dofs[a].name, simulated.dofs[b].name
                rows.append((world, *names, i, seed, mean_squared_error(*outcome)))
        return pd.DataFrame(rows, columns=flatland_commutation_experiments.column_names)

    return Batched(compute, size=20)
