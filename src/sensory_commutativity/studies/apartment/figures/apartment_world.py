"""The robots in an apartment, from outside and through their own camera (paper, Fig. "iGibson",
left and middle, and appendix C)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....seeding import generator
from ...config import Config
from ...declarations import figure
from .. import builders

PIXELS = 480
"""Height and width of each picture."""
EXPERIMENT = 1
"""Experiment whose start situation is shown."""


@figure(
    title="The robots in an apartment, from outside and through their own camera",
    settings=lambda config: [config.apartment, builders.described_files(config)],
)
def apartment_world(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A row per robot: the outside view, and the picture of each field of view."""
    from ....worlds.apartment.rendering.camera import Camera
    from ....worlds.apartment.rendering.drawing import render_third_person  # imports PyBullet

    settings = config.apartment
    compared, views = settings.robots_compared, settings.fields_of_view
    shown = [(settings.reference.robot, settings.reference.scene)]
    shown += [(robot, scene) for robot in compared.robots for scene in compared.scenes]
    n_columns = 1 + len(views)
    figure, grid = plt.subplots(
        len(shown), n_columns, figsize=(3.6 * n_columns, 3.8 * len(shown)), squeeze=False
    )
    for row, (robot, scene) in zip(grid, shown, strict=True):
        world = builders.apartment_world(config, robot, scene, "anywhere")
        seed = builders.start_seed(config, robot, scene, "anywhere", EXPERIMENT)
        world.reset(generator(seed, "situation"))
        simulation = world.simulation
        outside = render_third_person(simulation, PIXELS)
        _draw_picture(row[0], outside, f"{robot} in {scene}, start of experiment {EXPERIMENT}")
        for axes, view in zip(row[1:], views, strict=True):
            camera = Camera(PIXELS, PIXELS, view, settings.supersampling)
            picture = world.renderer.render(camera, simulation.camera_pose(), simulation.poses())
            _draw_picture(
                axes,
                picture.rgb,
                f"through its camera, {view:g} degrees; experiments\n"
                f"use {settings.image_size} × {settings.image_size} pixels",
            )
        simulation.close()
    return figure


def _draw_picture(axes: Axes, picture: np.ndarray, title: str) -> None:
    axes.imshow(picture)
    axes.set_title(title, fontsize=9)
    axes.set_axis_off()
