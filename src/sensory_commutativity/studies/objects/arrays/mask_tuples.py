"""SC-experiments on objects, to test the mask predictors on (paper, section IV-A, "Inference" and
"Evaluation").

The unit is a cluttered scene: one set of objects, in several layouts, with a random stream of its
own.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from ...config import Config
from ...declarations import Shard, Shards, arrays
from ..builders import (
    count_test_scenes,
    experiments_in_scene,
    load_masks_robot,
    make_test_sampler,
    tuple_runs,
    tuple_settings,
)


@arrays(
    title="SC-experiments on objects",
    inputs=["mask_dof"],
    shards=Shards(
        runs=lambda config: dict.fromkeys(tuple_runs(config), count_test_scenes(config)),
        settings=lambda config, run: [
            tuple_settings(config, run), experiments_in_scene(config, count_test_scenes(config) - 1)
        ],
        per_shard=lambda config: config.masks.tests.scenes_per_job,
    ),
)  # fmt: skip
def mask_tuples(
    mask_dof: pd.DataFrame, config: Config, shard: Shard
) -> tuple[dict[str, Any], dict[str, str]]:
    """The experiments of some scenes: arrays as :func:`.object_experiments.assemble_tuples` returns
    them, with the number of the scene and of the experiment, int32 (n,)."""
    from ....change_detection.simulated.object_experiments import (
        ObjectExperimentRunner,
        assemble_tuples,
    )
    from ....progress import progress

    run, tests = tuple_runs(config)[shard.run], config.masks.tests
    names = [dof.name for dof in load_masks_robot(config).dofs]
    dof = names.index(mask_dof["dof"].iloc[0])
    parts: list[dict[str, np.ndarray]] = []
    for scene in range(shard.start, shard.stop):
        sampler = make_test_sampler(config, run, scene)
        experiments = ObjectExperimentRunner(
            sampler, dof, tests.sequence_length, run.alternatives, config.apartment.rest_steps
        )
        n = experiments_in_scene(config, scene)
        description = f"{shard.name}, scene {scene}"
        played = [experiments.play() for _ in progress(range(n), description, "experiment")]
        first = scene * tests.experiments_per_scene
        parts.append(
            assemble_tuples(played, sampler)
            | dict(
                scene=np.full(n, scene, np.int32),
                experiment=np.arange(first, first + n, dtype=np.int32),
            )
        )
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}, {}
