"""Philipona's conjecture, tried (paper, section II-C): does a sequence of one degree of freedom commute with one of another?

From one start, h (of a) then g (of b) is played, and g then h. Which is called a does not matter, so each unordered pair is played once and stands in
the table twice. On the diagonal h and g are two different sequences of the same degree of freedom.

It is tried in the reference world and in a settled one, in which nothing moves by itself and what was pushed has time to come to rest: a world that
changes while the eye is shut does not wait for the hand.
"""

from __future__ import annotations

from itertools import combinations_with_replacement
from pathlib import Path

import pandas as pd

from ....scp.distances import mean_squared_error
from ....scp.estimate import commutes
from ....scp.experiment import commutation_experiment
from ....scp.sequences import sample_sequence
from ....seeding import generator, seed_for
from ....statistics.proportions import wilson_interval
from ....storage.batches import write_in_batches
from ....storage.tables import TABLES, read_table, write_table
from ...config import Config
from ..builders import flatland_world
from .flatland_experiments import part_bounds

PARTS = "flatland_commutation_experiments"
_COLUMNS = [column.name for column in TABLES[PARTS]]


def run_commutation(config: Config, name: str, start: int, stop: int) -> pd.DataFrame:
    """Experiments start <= i < stop of every unordered pair in the world `name`: columns of the table flatland_commutation_experiments."""
    flatland, rest_steps = config.flatland, config.flatland.commutation_worlds()[name]
    world = flatland_world(flatland, name, flatland.reference.agent)
    n, rows = len(world.dofs), []
    for i in range(start, stop):
        seed = seed_for(config.seed, "commutation", name, flatland.reference.agent, i)
        world.reset(generator(seed, "situation"))
        situation = world.snapshot()

        def sequence(k: int, which: str, seed: int = seed):
            return sample_sequence(
                generator(seed, which, world.dofs[k].name), flatland.sequence_length, k, n
            )

        first = [sequence(k, "first") for k in range(n)]
        for a, b in combinations_with_replacement(range(n), 2):
            g = sequence(b, "second") if a == b else first[b]
            distance = mean_squared_error(
                *commutation_experiment(world, situation, first[a], g, rest_steps)
            )
            rows.append((name, world.dofs[a].name, world.dofs[b].name, i, seed, distance))
    return pd.DataFrame(rows, columns=_COLUMNS)


def write_commutation_experiments(config: Config, name: str, part: int, out: Path) -> None:
    """Write one job's share of the experiments to `out`, resuming from finished batches."""
    flatland = config.flatland
    reference = flatland.reference
    start, stop = part_bounds(flatland.commutation_per_job, flatland.commutation.experiments, part)
    settings = (
        f"{config.seed} {flatland.sequence_length} {flatland.commutation_worlds()[name]} "
        f"{name} {flatland.worlds[name]!r} {reference.agent} {flatland.agents[reference.agent]!r}"
    )
    write_in_batches(
        PARTS,
        lambda low, high: run_commutation(config, name, low, high),
        start,
        stop,
        out,
        config,
        settings,
        batch=20,
    )


def write_commutation(parts: list[Path], out: Path, config: Config) -> None:
    """The probability that two degrees of freedom commute, at threshold 0: a row for every world and ordered pair."""
    frame = pd.concat([read_table(PARTS, part) for part in parts], ignore_index=True)
    frame["commuted"] = commutes(frame["distance"].to_numpy())
    table = (
        frame.groupby(["world", "dof_a", "dof_b"], sort=False)["commuted"]
        .agg(n="size", commuted="sum")
        .reset_index()
    )
    mirrored = table[table["dof_a"] != table["dof_b"]].rename(
        columns={"dof_a": "dof_b", "dof_b": "dof_a"}
    )
    table = pd.concat([table, mirrored], ignore_index=True)
    table["probability"] = table["commuted"] / table["n"]
    table["ci_low"], table["ci_high"] = wilson_interval(
        table["commuted"].to_numpy(), table["n"].to_numpy()
    )
    write_table("flatland_commutation", table, out, config)
