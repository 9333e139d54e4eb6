"""The robots in an apartment, from outside and through their own camera (paper, Fig. "iGibson", left and middle, and appendix C)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....seeding import generator
from ....worlds.apartment.rendering.camera import Camera
from ....worlds.apartment.rendering.drawing import render_third_person
from ...apartment.builders import described_files
from ...config import Config
from ...declarations import figure
from ..builders import apartment_world, start_seed

_PIXELS = 480
_SHOWN = 1
"""Which experiment's start situation is shown."""


def _show(axes: Axes, picture, title: str) -> None:
    axes.imshow(picture)
    axes.set_title(title, fontsize=9)
    axes.set_axis_off()


@figure(
    title="The robots in an apartment, from outside and through their own camera",
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_world(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    settings = config.apartment
    shown = [(settings.reference.robot, settings.reference.scene)]
    shown += [
        (robot, scene)
        for robot in settings.robots_compared.robots
        for scene in settings.robots_compared.scenes
    ]
    views = settings.fields_of_view
    figure, grid = plt.subplots(
        len(shown),
        1 + len(views),
        figsize=(3.6 * (1 + len(views)), 3.8 * len(shown)),
        squeeze=False,
    )
    for row, (robot, scene) in zip(grid, shown, strict=True):
        world = apartment_world(config, robot, scene, "anywhere")
        world.reset(generator(start_seed(config, robot, scene, "anywhere", _SHOWN), "situation"))
        _show(
            row[0],
            render_third_person(world.simulation, _PIXELS),
            f"{robot} in {scene}, start of experiment {_SHOWN}",
        )
        for axes, view in zip(row[1:], views, strict=True):
            camera = Camera(_PIXELS, _PIXELS, view, settings.supersampling)
            picture = world.renderer.render(
                camera, world.simulation.camera_pose(), world.simulation.poses()
            ).rgb
            _show(
                axes,
                picture,
                f"through its camera, {view:g} degrees; experiments\nuse {settings.image_size} × {settings.image_size} pixels",
            )
        world.simulation.close()
    return figure
