"""SC-experiments of robots in apartments: how unequal both orders look through VGG16, and what really happened (paper, section III-B).

Experiment *i* draws a start situation; every degree of freedom is then tried from it. All randomness follows from (root seed, robot, scene, start,
i); sequences of other lengths share the start situations.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ....errors import TableError
from ....scp.experiment import endings_per_dof
from ....storage.batches import write_in_batches
from ....storage.tables import TABLES, read_about, read_table, write_table
from ....worlds.apartment.world import ApartmentWorld, PrivilegedInfo
from ...config import Config
from ...flatland.tables.flatland_experiments import part_bounds
from ..builders import perceptual_features, settings_of_run, start_seed, world_of_run
from ..config import ApartmentRun

TABLE = "apartment_experiments"
BATCH = 5  # start situations; with ten degrees of freedom some 20 seconds
_COLUMNS = [column.name for column in TABLES[TABLE]]


def run_experiments(
    config: Config, run: ApartmentRun, world: ApartmentWorld, features: Any, start: int, stop: int
) -> pd.DataFrame:
    """Experiments start <= i < stop: a row per experiment, degree of freedom and field of view, columns of the table apartment_experiments."""
    rows, first, second = [], [], []
    views = config.apartment.views(run)
    for i in range(start, stop):
        seed = start_seed(config, run.robot, run.scene, run.start, i)
        for dof, (one, other) in endings_per_dof(
            world, seed, run.length, config.apartment.rest_steps
        ).items():
            events = _events(one.happened, other.happened)
            for k, field_of_view in enumerate(views):
                rows.append(
                    (
                        run.robot,
                        run.scene,
                        run.start,
                        run.length,
                        dof,
                        i,
                        seed,
                        field_of_view,
                        *events,
                    )
                )
                first.append(one.observation[k])
                second.append(other.observation[k])
    frame = pd.DataFrame(rows, columns=[name for name in _COLUMNS if name != "distance"])
    frame["distance"] = features.distances(np.stack(first), np.stack(second)).astype(float)
    return frame[_COLUMNS]


def _events(one: PrivilegedInfo, other: PrivilegedInfo) -> tuple[Any, ...]:
    """What happened in either order, and by how much the ends differ; the columns from touched_fixed on."""
    moved = np.maximum(one.object_shifts, other.object_shifts)
    return (
        max(one.touched_fixed, other.touched_fixed),
        max(one.touched_movable, other.touched_movable),
        max(one.touched_self, other.touched_self),
        max(one.at_limit, other.at_limit),
        float(moved.max(initial=0.0)),
        float(np.hypot(*(one.base[:2] - other.base[:2]))),
        float(abs(np.angle(np.exp(1j * (one.base[2] - other.base[2]))))),
        float(np.abs(one.joints - other.joints).max(initial=0.0)),
        one.clearance,
    )


def write_experiments(config: Config, run: ApartmentRun, part: int, out: Path) -> None:
    """Write one job's share of a run's experiments to `out`, resuming from finished batches."""
    import torch

    torch.set_num_threads(1)
    world, features = world_of_run(config, run), perceptual_features(config)
    start, stop = part_bounds(config.apartment.experiments_per_job, run.experiments, part)
    settings = json.dumps([settings_of_run(config, run), features.about])

    def compute(low: int, high: int) -> pd.DataFrame:
        return run_experiments(config, run, world, features, low, high)

    write_in_batches(
        TABLE, compute, start, stop, out, config, settings, BATCH, about=features.about
    )


def gather_experiments(parts: list[Path], out: Path, config: Config) -> None:
    """Put the parts of apartment_experiments together, in the order given. Raises TableError if they were seen through different weights."""
    frame = pd.concat([read_table(TABLE, part) for part in parts], ignore_index=True)
    weights = {read_about(part).get("vgg16_sha256", ""): part for part in parts}
    if len(weights) > 1:
        raise TableError(
            f"{' and '.join(map(str, weights.values()))}: made with different VGG16 weights; delete the parts and run again"
        )
    about = {key: value for key, value in read_about(parts[0]).items() if key.startswith("vgg16_")}
    write_table(TABLE, frame, out, config, about)
