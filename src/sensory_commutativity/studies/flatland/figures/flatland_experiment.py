"""An SC-experiment as a film: the same actions in two orders, side by side, from above and through the eye."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ....errors import ConfigError
from ....progress import progress
from ....scp.distances import mean_squared_error
from ....scp.experiment import final_observation
from ....scp.sequences import compose, no_op, permute, sample_sequence
from ....seeding import generator, seed_for
from ....storage.atomic import atomic_write
from ....worlds.flatland.drawing import draw_room, draw_view
from ....worlds.flatland.world import FlatlandSnapshot, FlatlandWorld
from ...config import Config
from ...plotting import Film, dof_label
from ..builders import flatland_world

TRIES = 500
FRAMES_PER_SECOND = 10
HOLD = 20  # frames that the end stands still


def find_experiment(
    config: Config, dof: str
) -> tuple[FlatlandWorld, FlatlandSnapshot, np.ndarray, np.ndarray]:
    """The first of the reference experiments of `dof` that does not commute; the last one tried when all of `TRIES` do."""
    reference = config.flatland.reference
    world = flatland_world(config.flatland, reference.world, reference.agent)
    names = [d.name for d in world.dofs]
    if dof not in names:
        raise ConfigError(f"--dof: there is no {dof!r}; choose one of {', '.join(names)}")
    for i in range(TRIES):
        seed = seed_for(config.seed, "flatland", reference.world, reference.agent, i)
        world.reset(generator(seed, "situation"))
        start = world.snapshot()
        rng = generator(seed, "sequence", dof)
        sequence = sample_sequence(
            rng, config.flatland.sequence_length, names.index(dof), len(names)
        )
        orders = sequence, permute(rng, sequence)
        ends = [
            final_observation(world, start, order, config.flatland.rest_steps) for order in orders
        ]
        if mean_squared_error(*ends) > 0:
            break
    return world, start, *orders


def animate_experiment(config: Config, dof: str, out: Path) -> None:
    """Film one SC-experiment of `dof` and save it as a GIF."""
    first, start, *orders = find_experiment(config, dof)
    second = FlatlandWorld(first.room, first.agent)
    worlds = (first, second)
    for world in worlds:
        world.restore(start)
    rest = no_op(config.flatland.rest_steps, len(first.dofs))
    films = [compose(order, rest) for order in orders]
    figure, axes = plt.subplots(2, 2, figsize=(7, 5.6), height_ratios=[14, 1])
    figure.subplots_adjust(left=0.02, right=0.98, bottom=0.03, top=0.88, hspace=0.16, wspace=0.04)

    def frame(step: int) -> list[np.ndarray]:
        views = [world.observe() for world in worlds]
        for k, world in enumerate(worlds):
            for panel in axes[:, k]:
                panel.clear()
            draw_room(axes[0, k], world)
            draw_view(axes[1, k], views[k])
            axes[0, k].set_title(("some order", "another order")[k], fontsize=10)
            axes[1, k].set_title("what the eye sees", fontsize=7, pad=2)
        figure.suptitle(
            f"{dof_label(dof)}: the same {len(orders[0])} actions in two orders, step {min(step, len(orders[0]))}",
            fontsize=11,
        )
        return views

    with atomic_write(out) as temporary:
        writer = Film(FRAMES_PER_SECOND, config)
        with writer.saving(figure, str(temporary), dpi=90):
            views = frame(0)
            writer.grab_frame()
            for step in progress(range(len(films[0])), "filming", "step"):
                for world, film in zip(worlds, films, strict=True):
                    world.step(film[step])
                views = frame(step + 1)
                writer.grab_frame()
            error = mean_squared_error(*views)
            verdict = (
                "equal: they commute"
                if error == 0
                else f"not equal: they do not commute (mean squared error {error:.0f})"
            )
            figure.suptitle(f"{dof_label(dof)}: the sensors end {verdict}", fontsize=11)
            for _ in range(HOLD):
                writer.grab_frame()
    plt.close(figure)
