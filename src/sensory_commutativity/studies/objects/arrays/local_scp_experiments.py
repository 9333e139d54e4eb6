"""SC-experiments at the poses of the map, and what truly is within reach there (paper, Fig. "SCP
map"). Every pose has a random stream of its own."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from ....seeding import generator
from ...config import Config
from ...declarations import Shard, Shards, arrays
from ..builders import (
    find_first_arm_dof,
    load_masks_robot,
    load_named_scene,
    make_masks_cameras,
    map_poses,
    map_settings,
)

RUN = "poses"


@arrays(
    title="SC-experiments at the poses of the map",
    shards=Shards(
        runs=lambda config: {RUN: len(map_poses(config))},
        settings=lambda config, run: map_settings(config),
        per_shard=lambda config: config.masks.map.poses_per_job,
    ),
)
def local_scp_experiments(config: Config, shard: Shard) -> tuple[dict[str, Any], dict[str, str]]:
    """Play the experiments at some poses; poses where the robot cannot stand are left out.

    Returns
    -------
    arrays : dict
        pictures uint8 (poses * n, 2, h, w, 3), different bool (poses, n), pose float64 (poses, 3):
        x and y (m), heading (rad), clearance float64 (poses,) (m), over_low bool (poses,).
    texts : dict
        dof, rooms and nearest (JSON lists).
    """
    from ....change_detection.simulated.local_scp import play_local_experiments
    from ....change_detection.simulated.reach import measure_median_reach, median_excursion
    from ....progress import progress
    from ....worlds.apartment.world import ApartmentWorld

    settings, robot = config.masks.map, load_masks_robot(config)
    dof = find_first_arm_dof(robot)
    cameras = make_masks_cameras(config, [config.masks.data.field_of_view])
    world = ApartmentWorld(load_named_scene(config, settings.scene), robot, cameras)
    joint = [j.name for j in robot.joints].index(robot.description.dofs[dof].joints[0])
    rng = generator(config.seed, "masks", "map", "excursion")
    excursion = median_excursion(settings.sequence_length, world.dofs[dof].speed, rng)
    poses, played, reaches = [], [], []
    for pose in progress(map_poses(config)[shard.start : shard.stop], shard.name, "pose"):
        position = f"{pose.x:.4f} {pose.y:.4f} {pose.heading:.4f}"
        rng = generator(config.seed, "masks", "map", settings.scene, pose.room, position)
        experiments = play_local_experiments(
            pose, world, dof, settings.sequence_length, settings.experiments, rng,
            config.apartment.rest_steps,
        )  # fmt: skip
        if experiments is not None:
            poses.append(pose)
            played.append(experiments)
            reaches.append(
                measure_median_reach(
                    world.simulation, np.array(pose[1:]), joint, excursion, settings.low_furniture,
                    experiments.starts,
                )
            )  # fmt: skip
    size, n = config.masks.image_size, settings.experiments
    content = dict(
        pictures=np.array([one.pictures for one in played], np.uint8).reshape(-1, 2, size, size, 3),
        different=np.array([one.different for one in played], bool).reshape(-1, n),
        pose=np.array([pose[1:] for pose in poses], np.float64).reshape(-1, 3),
        clearance=np.array([reach.clearance for reach in reaches], np.float64),
        over_low=np.array([reach.over_low for reach in reaches], bool),
    )
    texts = dict(
        dof=world.dofs[dof].name,
        rooms=json.dumps([pose.room for pose in poses]),
        nearest=json.dumps([reach.nearest for reach in reaches]),
    )
    return content, texts
