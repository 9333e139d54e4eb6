"""The navigation task, and what the agents learn with each action space (paper, Fig. "RL task,
Results")."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import GREY, SPACE_COLOURS, SPACE_LINES, SPACE_MARKERS
from ..builders import evaluation_seeds, navigation_environment
from ..tables.navigation_comparisons import pairs


@figure(
    title="The navigation task, and learning curves of every action space",
    inputs=["navigation_curves", "navigation_checkpoints"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_learning(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """The room and the view at the start of an episode; learning curves."""
    navigation, curves = config.navigation, tables["navigation_curves"]
    figure = plt.figure(figsize=(12, 5.2))
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.65], height_ratios=[14, 1])
    room, view = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
    axes = figure.add_subplot(grid[:, 1])
    _draw_task(room, view, config)
    for action_space in navigation.action_spaces:
        _draw_curve(axes, curves[curves["action_space"] == action_space], action_space)
    rewards = [zone.reward for zone in navigation.zones]
    best = max(rewards)
    line = 0.05 * (best - min(rewards))
    axes.axhline(navigation.threshold_return, color=GREY, linewidth=0.8, linestyle=":")
    axes.text(
        navigation.steps / 1000, navigation.threshold_return, "threshold ", fontsize=7.5,
        color=GREY, va="bottom", ha="right",
    )  # fmt: skip
    _draw_differences(axes, tables["navigation_checkpoints"], config, best + 3.4 * line, line)
    axes.set_ylim(min(-0.05 * best, curves["episode_return"].min()), best + 4 * line)
    axes.set_xlabel("environment steps of training (thousands)")
    axes.set_ylabel("mean return of an evaluation episode")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.86), title="action space")
    axes.set_title(
        f"n = {len(navigation.seeds)} runs each; mean, 95 % interval (dark), middle 80 % of runs "
        "(light)\n"
        "marks on top: checkpoints where the pair differs, in the better one's colour "
        f"(Welch, Holm, p < {navigation.alpha:g})"
    )
    return figure


def _draw_task(room: Axes, view: Axes, config: Config) -> None:
    """Draw the room and the view at the start of the first evaluation episode."""
    from ....worlds.flatland.drawing import draw_room, draw_view  # imports numba and pymunk

    environment = navigation_environment(config)
    observation, _ = environment.reset(seed=evaluation_seeds(config)[0])
    draw_room(room, environment.world)
    room.set_title("the task: reach the goal, keep out of the dead zones")
    for zone in environment.zones:
        text = f"{'goal' if zone.is_goal else 'dead zone'}\n{zone.reward:+g}"
        room.text(zone.x, zone.y, text, ha="center", va="center", fontsize=8, zorder=8)
    draw_view(view, observation)
    view.set_title("what the eye sees", fontsize=8, pad=2)


def _draw_curve(axes: Axes, runs: pd.DataFrame, action_space: str) -> None:
    """Draw the mean over runs, its 95 % interval (Student's t), and the middle 80 % of the runs."""
    from scipy import stats

    table = runs.pivot(index="step", columns="seed", values="episode_return")
    steps, returns, n = table.index / 1000, table.to_numpy(), table.shape[1]  # returns: (steps, n)
    mean = returns.mean(axis=1)
    half = stats.t.ppf(0.975, n - 1) * returns.std(axis=1, ddof=1) / np.sqrt(n)
    low, high = np.percentile(returns, [10, 90], axis=1)
    colour = SPACE_COLOURS[action_space]
    axes.fill_between(steps, low, high, color=colour, alpha=0.07, linewidth=0)
    axes.fill_between(steps, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
    axes.plot(
        steps, mean, color=colour, linewidth=1.6, linestyle=SPACE_LINES[action_space],
        marker=SPACE_MARKERS[action_space], markersize=3.5, label=action_space,
    )  # fmt: skip


def _draw_differences(
    axes: Axes, checkpoints: pd.DataFrame, config: Config, top: float, line: float
) -> None:
    """Draw a row of marks per pair of the paper, at the checkpoints where the pair differs.

    The first row is at y = `top`, each other one `line` below.
    """
    significant = checkpoints[checkpoints["p_adjusted"] < config.navigation.alpha]
    for i, (_, a, b) in enumerate(pair for pair in pairs(config) if pair[0] == "paper"):
        y = top - i * line
        rows = significant[(significant["a"] == a) & (significant["b"] == b)]
        for step, difference in zip(rows["step"], rows["difference"], strict=True):
            better = a if difference > 0 else b
            style: dict[str, Any] = dict(marker=SPACE_MARKERS[better], color=SPACE_COLOURS[better])
            axes.plot(step / 1000, y, markersize=4, **style)
        transform = axes.get_yaxis_transform()
        axes.text(1.01, y, f"{a} − {b}", fontsize=7.5, va="center", transform=transform)
