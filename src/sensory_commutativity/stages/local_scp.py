"""The local SCP at every place of an apartment, decided by the mask predictor, and what truly is in reach there (paper, Fig. "SCP map")."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ..config import Config
from ..mapping.local import experiments_at
from ..mapping.sweep import swept_reach, usual_range
from ..masks.decision import outcomes
from ..masks.from_config import cameras_of_masks, first_of_arm, places_of_map, robot_of_masks
from ..masks.outcome import OUTCOMES
from ..masks.predictor import load_predictor
from ..progress import progress
from ..seeding import generator
from ..statistics.proportions import wilson_interval
from ..tables import TABLES, read_table, write_table
from ..worlds.apartment.from_config import scene_of
from ..worlds.apartment.world import ApartmentWorld
from .mask_comparisons import BETTER

TABLE = "local_scp"


def write_local_scp_part(config: Config, part: int, predictor: Path, out: Path) -> None:
    """A job's places; those where the robot cannot stand have no row."""
    settings = config.masks.map
    loaded, robot = load_predictor(predictor, BETTER), robot_of_masks(config)
    dof = first_of_arm(robot)
    world = ApartmentWorld(scene_of(config.apartment, settings.scene), robot, cameras_of_masks(config, [config.masks.data.field_of_view]))
    joint = [one.name for one in robot.joints].index(robot.description.dofs[dof].joints[0])
    starts = tuple(robot.start_ranges[joint])
    between = usual_range(settings.sequence_length, world.dofs[dof].speed, starts, generator(config.seed, "masks", "map", "range"))
    mine = places_of_map(config)[part * settings.places_per_job : (part + 1) * settings.places_per_job]
    rows = []
    for place in progress(mine, out.stem, "place"):
        rng = generator(config.seed, "masks", "map", settings.scene, place.room, f"{place.x:.4f} {place.y:.4f} {place.heading:.4f}")
        seen = experiments_at(place, world, dof, settings.sequence_length, settings.experiments, rng)
        if seen is None:
            continue
        called = outcomes(loaded.probabilities(seen.pictures), loaded.rule) == OUTCOMES.index("different")
        n, same = len(called), int((~called).sum())
        reach = swept_reach(world.simulation, np.array(place[1:]), joint, between, settings.low)
        within = reach.clearance <= 0
        rows.append(
            (settings.scene, world.dofs[dof].name, *place, n, n - same, same / n,
             *(float(end) for end in wilson_interval(same, n)), float((~seen.different).mean()),
             reach.clearance, within, reach.nearest, reach.over_low and not within)
        )  # fmt: skip
    write_table(TABLE, pd.DataFrame(rows, columns=[column.name for column in TABLES[TABLE]]), out, config)


def gather_local_scp(parts: Sequence[Path], out: Path, config: Config) -> None:
    """Put the places together, in the order given."""
    write_table(TABLE, pd.concat([read_table(TABLE, part) for part in parts], ignore_index=True), out, config)
