"""SC-experiments of robots in apartments (paper, section III-B): how different the final images of
the two orders are in terms of VGG16 features, and what the robot touched.

Experiment i draws a start situation, from which every degree of freedom is tried, with a sequence
and a permutation of its own. Sequences of other lengths share the start situations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import pandas as pd

from ....scp.experiment import endings_per_dof
from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shard, Shards, table
from ..builders import (
    build_run_world,
    count_dofs,
    experiment_runs,
    perceptual_features,
    settings_of_run,
    start_seed,
)
from ..columns import CONDITION, DOF, VIEW
from ..config import ApartmentRun

if TYPE_CHECKING:
    from ....worlds.apartment.world import ApartmentWorld, PrivilegedInfo


class ImageDistance(Protocol):
    """Distances of images, pair by pair."""

    def distances(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Two arrays uint8 (n, height, width, 3) -> (n,)."""


def run_experiments(
    config: Config,
    run: ApartmentRun,
    world: ApartmentWorld,
    features: ImageDistance,
    start: int,
    stop: int,
) -> pd.DataFrame:
    """Play the experiments start <= i < stop of a run.

    Parameters
    ----------
    config : Config
    run : ApartmentRun
    world : ApartmentWorld
        The world of the run, with a camera for each of its fields of view.
    features : ImageDistance
    start, stop : int

    Returns
    -------
    DataFrame
        Columns of the table apartment_experiments; a row per experiment, degree of freedom and
        field of view.
    """
    rows, first, second = [], [], []  # the images of both orders, (height, width, 3) each
    views, rest_steps = config.apartment.views(run), config.apartment.rest_steps
    for i in range(start, stop):
        seed = start_seed(config, run.robot, run.scene, run.start, i)
        endings = endings_per_dof(world, seed, run.length, rest_steps)
        for dof, (a, b) in endings.items():
            events = _events(a.happened, b.happened)
            rows += [(*run[:4], dof, i, seed, view, *events) for view in views]
            first += list(a.observation)
            second += list(b.observation)
    names = apartment_experiments.column_names
    frame = pd.DataFrame(rows, columns=names[:-1])
    return frame.assign(
        distance=features.distances(np.stack(first), np.stack(second)).astype(float)
    )


def _events(a: PrivilegedInfo, b: PrivilegedInfo) -> tuple[Any, ...]:
    """The columns touched_fixed to clearance: touch in either order, and how the ends differ."""
    shifts = np.maximum(a.object_shifts, b.object_shifts)
    return (
        max(a.touched_fixed, b.touched_fixed),
        max(a.touched_movable, b.touched_movable),
        max(a.touched_self, b.touched_self),
        max(a.at_limit, b.at_limit),
        float(shifts.max(initial=0.0)),
        float(np.hypot(*(a.base[:2] - b.base[:2]))),
        float(abs(np.angle(np.exp(1j * (a.base[2] - b.base[2]))))),
        float(np.abs(a.joints - b.joints).max(initial=0.0)),
        a.clearance,
    )


def _units(config: Config) -> dict[str, int]:
    return {name: run.experiments for name, run in experiment_runs(config).items()}


def _expected(config: Config) -> tuple[Expected, ...]:
    settings, dofs = config.apartment, count_dofs(config.apartment)
    counts = {
        run[:4]: run.experiments * dofs[run.robot] * len(settings.views(run))
        for run in settings.runs()
    }
    units = {
        (*run[:4], i): counts[run[:4]] // run.experiments
        for run in settings.runs()
        for i in range(run.experiments)
    }
    return (
        Expected(("robot", "apartment", "start", "length"), counts),
        Expected(("robot", "apartment", "start", "length", "experiment"), units),
    )


def _expected_shard(config: Config, shard: Shard) -> Expected:
    settings, run = config.apartment, experiment_runs(config)[shard.run]
    n = count_dofs(settings)[run.robot] * len(settings.views(run))
    rows = {(*run[:4], i): n for i in range(shard.start, shard.stop)}
    return Expected(("robot", "apartment", "start", "length", "experiment"), rows)


@table(
    title="SC-experiments in apartments",
    columns=(
        *CONDITION,
        DOF,
        Column(
            "experiment", INT, "1",
            "number of the experiment; all degrees of freedom share its start situation", key=True,
        ),
        Column("seed", INT, "1", "seed of the experiment"),
        VIEW,
        Column(
            "touched_fixed", INT, "steps",
            "steps in which the robot touched a fixture, in the order with more of them",
        ),
        Column("touched_movable", INT, "steps", "as touched_fixed, for movable objects"),
        Column("touched_self", INT, "steps", "as touched_fixed, for the robot's own body"),
        Column(
            "at_limit", INT, "steps",
            "steps in which a joint was commanded beyond its limit, in the order with more of them",
        ),
        Column(
            "object_shift", FLOAT, "m", "largest displacement of an object in either order",
            low=0,
        ),
        Column(
            "base_difference", FLOAT, "m", "distance between the two final base positions",
            low=0,
        ),
        Column("turn_difference", FLOAT, "rad", "difference of the two final headings", low=0),
        Column(
            "joint_difference", FLOAT, "rad or m",
            "largest difference between the two final positions of a joint", low=0,
        ),
        Column(
            "clearance", FLOAT, "m",
            "distance from the arm to the nearest obstacle at the start; 1 if it is larger",
        ),
        Column(
            "distance", FLOAT, "squared VGG16 feature",
            "squared distance of the features of the two final observations", low=0,
        ),
    ),
    shards=Shards(
        runs=_units,
        settings=lambda config, run: settings_of_run(config, experiment_runs(config)[run]),
        per_shard=lambda config: config.apartment.experiments_per_job,
    ),
    expected=_expected,
    expected_shard=_expected_shard,
)  # fmt: skip
def apartment_experiments(config: Config, run: str) -> Batched:
    """Play the SC-experiments of one robot in one scene.

    The source and the hash of the VGG16 weights are stored in the file.
    """
    import torch

    torch.set_num_threads(1)
    settings = experiment_runs(config)[run]
    world, features = build_run_world(config, settings), perceptual_features(config)

    def compute(start: int, stop: int) -> pd.DataFrame:
        return run_experiments(config, settings, world, features, start, stop)

    return Batched(compute, size=5, metadata=features.metadata)
