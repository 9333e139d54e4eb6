"""The local SCP at every place of an apartment, decided by the mask predictor, and what truly is in reach there (paper, Fig. "SCP map").

Experiments are played, and their final pictures kept, before any predictor is trained; another predictor looks at the same pictures.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ....change_detection.decision import outcomes
from ....change_detection.outcome import OUTCOMES
from ....change_detection.predictor import load_predictor
from ....change_detection.simulated.local_scp import Seen, experiments_at
from ....change_detection.simulated.poses import Pose
from ....change_detection.simulated.reach import Reach, usual_excursion, usual_reach
from ....progress import progress
from ....seeding import generator
from ....statistics.proportions import wilson_interval
from ....storage.arrays import REMEDY, StoreError, read_arrays, write_arrays
from ....storage.batches import write_in_batches
from ....storage.provenance import provenance
from ....storage.tables import TABLES
from ....worlds.apartment.world import ApartmentWorld
from ...apartment.builders import scene_of
from ...config import Config
from ..builders import (
    cameras_of_masks,
    first_of_arm,
    places_of_map,
    robot_of_masks,
    settings_of_map,
)
from .mask_comparisons import BETTER

TABLE = "local_scp"
CONTENT = "experiments of a map"


def write_local_scp_experiments(config: Config, part: int, out: Path) -> None:
    """Play the experiments at a job's places; those where the robot cannot stand are left out."""
    settings = config.masks.map
    robot = robot_of_masks(config)
    dof = first_of_arm(robot)
    world = ApartmentWorld(
        scene_of(config.apartment, settings.scene),
        robot,
        cameras_of_masks(config, [config.masks.data.field_of_view]),
    )
    joint = [one.name for one in robot.joints].index(robot.description.dofs[dof].joints[0])
    excursion = usual_excursion(
        settings.sequence_length,
        world.dofs[dof].speed,
        generator(config.seed, "masks", "map", "excursion"),
    )
    found: list[tuple[Pose, Seen, Reach]] = []
    for place in progress(places_of_map(config)[_of_job(config, part)], out.stem, "place"):
        rng = generator(
            config.seed,
            "masks",
            "map",
            settings.scene,
            place.room,
            f"{place.x:.4f} {place.y:.4f} {place.heading:.4f}",
        )
        seen = experiments_at(
            place, world, dof, settings.sequence_length, settings.experiments, rng
        )
        if seen is not None:
            reach = usual_reach(
                world.simulation, np.array(place[1:]), joint, excursion, settings.low_furniture, seen.starts
            )
            found.append((place, seen, reach))
    size, n = config.masks.image_size, settings.experiments
    arrays = dict(
        pictures=np.array([seen.pictures for _, seen, _ in found], np.uint8).reshape(
            -1, 2, size, size, 3
        ),
        different=np.array([seen.different for _, seen, _ in found], bool).reshape(-1, n),
        pose=np.array([place[1:] for place, _, _ in found], np.float64).reshape(-1, 3),
        clearance=np.array([reach.clearance for *_, reach in found], np.float64),
        over_low=np.array([reach.over_low for *_, reach in found], bool),
    )
    about = dict(dof=world.dofs[dof].name, rooms=json.dumps([place.room for place, *_ in found]))
    write_arrays(
        out,
        CONTENT,
        arrays,
        {
            **about,
            "nearest": json.dumps([reach.nearest for *_, reach in found]),
            **provenance(config),
        },
    )


def write_local_scp(
    config: Config, experiments: Sequence[Path], predictor: Path, out: Path
) -> None:
    """Let a predictor look at the pictures of all places, in the order given, resuming from finished files."""
    loaded, columns = load_predictor(predictor, BETTER), [column.name for column in TABLES[TABLE]]

    def compute(start: int, stop: int) -> pd.DataFrame:
        return pd.DataFrame(
            [row for path in experiments[start:stop] for row in _rows(path, loaded, config)],
            columns=columns,
        )

    settings = settings_of_map(config)
    write_in_batches(
        TABLE,
        compute,
        0,
        len(experiments),
        out,
        config,
        settings,
        batch=1,
        sources=[predictor, *experiments],
    )


def _of_job(config: Config, part: int) -> slice:
    n = config.masks.map.poses_per_job
    return slice(part * n, (part + 1) * n)


def _rows(path: Path, predictor, config: Config) -> list[tuple]:
    """A file's rows of the table."""
    arrays, about = read_arrays(path, CONTENT)
    different = OUTCOMES.index("different")
    rooms, nearest = json.loads(about["rooms"]), json.loads(about["nearest"])
    n = arrays["different"].shape[1]
    if n != config.masks.map.experiments:
        raise StoreError(
            f"{path}: {n} experiments at a place, where the configuration asks for {config.masks.map.experiments}; {REMEDY}"
        )
    called = (
        outcomes(predictor.probabilities(arrays["pictures"]), predictor.rule) == different
    ).reshape(-1, n)
    rows = []
    for k, (room, pose) in enumerate(zip(rooms, arrays["pose"], strict=True)):
        same, clearance = int((~called[k]).sum()), float(arrays["clearance"][k])
        within = clearance <= 0
        rows.append(
            (config.masks.map.scene, about["dof"], room, *(float(value) for value in pose), n, n - same, same / n,
             *(float(end) for end in wilson_interval(same, n)), float((~arrays["different"][k]).mean()),
             clearance, within, nearest[k], bool(arrays["over_low"][k]) and not within)
        )  # fmt: skip
    return rows
