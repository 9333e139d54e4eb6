"""SC-experiments of every robot of the gallery in every scene: distances, and what was touched."""

from __future__ import annotations

import pandas as pd

from ....scp.distances import mean_squared_error
from ....scp.experiment import endings_per_dof
from ....seeding import seed_for
from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shards, table
from ..builders import build_gallery_world, gallery, runs, settings_of_run
from ..columns import DOF, GROUP, ROBOT, SCENE


def _expected(config: Config) -> Expected:
    return Expected(("robot", "scene"), dict.fromkeys(runs(config).values()))


@table(
    title="SC-experiments of the gallery of robots",
    columns=(
        ROBOT,
        SCENE,
        DOF,
        GROUP,
        Column("experiment", INT, "1", "number of the start situation", key=True),
        Column("distance", FLOAT, "1", "mean squared error of the two final images, 8-bit levels"),
        Column("touched", INT, "steps", "steps that touched the scene, in the order with more"),
        Column("touched_self", INT, "steps", "as touched, for the robot's own body"),
        Column("at_limit", INT, "steps", "as touched: a joint was commanded beyond its limit"),
    ),
    shards=Shards(
        runs=lambda config: {name: gallery(config).starts for name in runs(config)},
        settings=settings_of_run,
        per_shard=lambda config: gallery(config).starts_per_job,
    ),
    expected=_expected,
)
def gallery_experiments(config: Config, run: str) -> Batched:
    """Play the SC-experiments of one robot in one scene."""
    settings, (robot, scene) = gallery(config), runs(config)[run]
    world = build_gallery_world(config, robot, scene)
    groups = {dof.name: dof.group for dof in world.robot.description.dofs}

    def compute(start: int, stop: int) -> pd.DataFrame:
        rows = []
        for i in range(start, stop):
            seed = seed_for(config.seed, "gallery", run, i)
            endings = endings_per_dof(world, seed, settings.sequence_length, settings.rest_steps)
            for dof, (first, second) in endings.items():
                a, b = first.happened, second.happened
                rows.append(
                    (
                        robot, scene, dof, groups[dof], i,
                        mean_squared_error(first.observation, second.observation),
                        max(a.touched_fixed + a.touched_movable,
                            b.touched_fixed + b.touched_movable),
                        max(a.touched_self, b.touched_self),
                        max(a.at_limit, b.at_limit),
                    )
                )  # fmt: skip
        return pd.DataFrame(rows, columns=gallery_experiments.column_names)

    return Batched(compute, size=5)
