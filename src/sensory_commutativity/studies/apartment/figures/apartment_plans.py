"""The apartments from above, with the places where experiments started."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ....worlds.apartment.rendering.drawing import render_plan
from ...apartment.builders import described_files
from ...config import Config
from ...declarations import figure
from ...plotting import VERMILION
from ..builders import apartment_world, start_poses

_STARTS = 40


@figure(
    title="The apartments from above, with the places where experiments started",
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_plans(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    settings = config.apartment
    robot = settings.reference.robot
    runs = [
        run
        for run in settings.runs()
        if run.robot == robot
        and settings.scenes[run.scene].file is not None
        and run.start == "anywhere"
    ]
    scenes = {run.scene: run.experiments for run in runs if run.length == settings.sequence_length}
    figure, grid = plt.subplots(1, len(scenes), figsize=(5.2 * len(scenes), 5.6), squeeze=False)
    for axes, (scene, experiments) in zip(grid[0], scenes.items(), strict=True):
        world = apartment_world(config, robot, scene, "anywhere")
        picture, extent = render_plan(world.simulation)
        axes.imshow(picture, extent=extent)
        shown = min(_STARTS, experiments)
        poses = start_poses(config, robot, scene, "anywhere", shown)
        axes.quiver(
            poses[:, 0],
            poses[:, 1],
            np.cos(poses[:, 2]),
            np.sin(poses[:, 2]),
            color=VERMILION,
            scale=22,
            width=0.006,
        )
        axes.set_xlabel("metres")
        axes.set_ylabel("metres")
        about = (
            f"{scene}: {len(world.scene.areas)} rooms, {len(world.scene.movables)} movable objects"
        )
        axes.set_title(
            f"{about}\narrows: where the first {shown} experiments of {robot} start", fontsize=9
        )
        world.simulation.close()
    return figure
