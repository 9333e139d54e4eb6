"""Animation of one SC-experiment: the same actions in two orders, side by side, from above and
through the eye."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np

from ....progress import progress
from ....scp.distances import mean_squared_error
from ....scp.experiment import compare_orders, iterate_order, orders_per_dof
from ....seeding import generator, seed_for
from ...config import Config
from ...declarations import animation
from ...plotting import GifWriter, dof_label
from ..builders import flatland_world

if TYPE_CHECKING:
    from ....worlds.flatland.world import FlatlandSnapshot, FlatlandWorld

DOF = "left-shoulder"
MOST_EXPERIMENTS = 500
FRAMES_PER_SECOND = 10
LAST_FRAMES = 20
"""How often the last frame is repeated."""


def find_experiment(
    config: Config, dof: str = DOF
) -> tuple[FlatlandWorld, FlatlandSnapshot, np.ndarray, np.ndarray]:
    """The first of the reference experiments of `dof` that does not commute.

    If the first MOST_EXPERIMENTS all commute, it is the last of these.

    Returns
    -------
    world, start
    sequence, permuted : float (length, n_dofs)
    """
    flatland, reference = config.flatland, config.flatland.reference
    world = flatland_world(flatland, reference.world, reference.agent)
    for i in range(MOST_EXPERIMENTS):
        seed = seed_for(config.seed, "flatland", reference.world, reference.agent, i)
        world.reset(generator(seed, "situation"))
        start = world.snapshot()
        orders = orders_per_dof(world, seed, flatland.sequence_length)
        sequence, permuted = next(pair for name, *pair in orders if name == dof)
        outcome = compare_orders(world, start, sequence, permuted, flatland.rest_steps)
        if mean_squared_error(*outcome) > 0:
            break
    return world, start, sequence, permuted


@animation(
    title="One SC-experiment in Flatland, both orders side by side",
    settings=lambda config: config.flatland,
)
def flatland_experiment(config: Config, run: None, out: Path) -> None:
    """Write the animation as a GIF."""
    from ....worlds.flatland.drawing import draw_room, draw_view
    from ....worlds.flatland.world import FlatlandWorld

    world, start, *orders = find_experiment(config)
    worlds = (world, FlatlandWorld(world.room, world.agent))
    figure, axes = plt.subplots(2, 2, figsize=(7, 5.6), height_ratios=[14, 1])
    figure.subplots_adjust(left=0.02, right=0.98, bottom=0.03, top=0.88, hspace=0.16, wspace=0.04)

    def draw(step: int, views: tuple[np.ndarray, ...]) -> None:
        for k, name in enumerate(("first order", "second order")):
            for panel in axes[:, k]:
                panel.clear()
            draw_room(axes[0, k], worlds[k])
            draw_view(axes[1, k], views[k])
            axes[0, k].set_title(name, fontsize=10)
            axes[1, k].set_title("what the eye sees", fontsize=7, pad=2)
        length = len(orders[0])
        figure.suptitle(
            f"{dof_label(DOF)}: the same {length} actions in two orders, step {min(step, length)}",
            fontsize=11,
        )

    played = [
        iterate_order(player, start, order, config.flatland.rest_steps)
        for player, order in zip(worlds, orders, strict=True)
    ]
    with GifWriter(figure, out, config, FRAMES_PER_SECOND, dpi=90) as film:
        views: tuple[np.ndarray, ...] = ()
        for step, views in enumerate(progress(zip(*played, strict=True), "animating", "step")):
            draw(step, views)
            film.grab_frame()
        error = mean_squared_error(*views)
        result = (
            "equal: they commute"
            if error == 0
            else f"not equal: they do not commute (mean squared error {error:.0f})"
        )
        figure.suptitle(f"{dof_label(DOF)}: the sensors end {result}", fontsize=11)
        for _ in range(LAST_FRAMES):
            film.grab_frame()
