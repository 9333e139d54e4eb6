"""The apartments from above, with the poses in which experiments started."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import VERMILION
from ..builders import apartment_world, described_files, start_poses

MAX_STARTS = 40
"""Starts that are shown of each apartment, the first. Chosen: more would hide the plan."""


@figure(
    title="The apartments from above, with start poses of the robot",
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_plans(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A plan per apartment of the reference robot's runs, with an arrow per start."""
    from ....worlds.apartment.rendering.drawing import render_plan  # imports PyBullet

    settings = config.apartment
    robot = settings.reference.robot
    experiments = {
        run.scene: run.experiments
        for run in settings.runs()
        if run.robot == robot
        and run.start == "anywhere"
        and run.length == settings.sequence_length
        and settings.scenes[run.scene].file is not None
    }
    n_scenes = len(experiments)
    figure, grid = plt.subplots(1, n_scenes, figsize=(5.2 * n_scenes, 5.6), squeeze=False)
    for axes, (scene, n) in zip(grid[0], experiments.items(), strict=True):
        world = apartment_world(config, robot, scene, "anywhere")
        picture, extent = render_plan(world.simulation)
        world.simulation.close()
        axes.imshow(picture, extent=extent)
        n_starts = min(MAX_STARTS, n)
        x, y, heading = start_poses(config, robot, scene, "anywhere", n_starts).T
        axes.quiver(x, y, np.cos(heading), np.sin(heading), color=VERMILION, scale=22, width=0.006)
        axes.set_xlabel("metres")
        axes.set_ylabel("metres")
        axes.set_title(
            f"{scene}: {len(world.scene.areas)} rooms, {len(world.scene.movables)} movable "
            "objects\n"
            f"arrows: where the first {n_starts} experiments of {robot} start",
            fontsize=9,
        )
    return figure
