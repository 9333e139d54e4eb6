"""SC-experiments of every degree of freedom of an agent in a world (paper, definition 3 and section III-A).

Experiment *i* draws a start situation; every degree of freedom is then tried from it, with a sequence and a permutation of its own. All randomness
follows from (root seed, stage, world, agent, i), so the result does not depend on how experiments are cut into jobs and batches.
"""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....scp.experiment import distances_per_dof
from ....seeding import seed_for
from ....storage.batches import write_in_batches
from ....storage.tables import TABLES
from ...config import Config
from ..builders import flatland_world
from ..config import Run

TABLE = "flatland_experiments"
_COLUMNS = [column.name for column in TABLES[TABLE]]


def run_experiments(config: Config, run: Run, start: int, stop: int) -> pd.DataFrame:
    """Experiments start <= i < stop: a row per experiment and degree of freedom, columns of the table flatland_experiments."""
    world = flatland_world(config.flatland, run.world, run.agent)
    rows = []
    for i in range(start, stop):
        seed = seed_for(config.seed, "flatland", run.world, run.agent, i)
        found = distances_per_dof(world, seed, run.length, rest_steps=config.flatland.rest_steps)
        rows += [
            (run.world, run.agent, run.length, dof, i, seed, distance)
            for dof, distance in found.items()
        ]
    return pd.DataFrame(rows, columns=_COLUMNS)


def part_bounds(per_job: int, n: int, part: int) -> tuple[int, int]:
    """Which of `n` experiments the job number `part`, from 0, does: start <= i < stop."""
    return part * per_job, min(n, (part + 1) * per_job)


def write_experiments(config: Config, run: Run, part: int, out: Path) -> None:
    """Write one job's share of a run's experiments to `out`, resuming from finished batches."""
    start, stop = part_bounds(config.flatland.experiments_per_job, run.experiments, part)
    settings = f"{config.seed} {run} {config.flatland.rest_steps} {config.flatland.worlds[run.world]!r} {config.flatland.agents[run.agent]!r}"

    def compute(low: int, high: int) -> pd.DataFrame:
        return run_experiments(config, run, low, high)

    write_in_batches(TABLE, compute, start, stop, out, config, settings)
