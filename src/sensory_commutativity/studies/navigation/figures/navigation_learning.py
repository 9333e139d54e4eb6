"""The navigation task, and what the agents learn with each action space (paper, Fig. "RL task, Results")."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy import stats

from ....worlds.flatland.drawing import draw_room, draw_view
from ...config import Config
from ...declarations import figure
from ...plotting import GREY, SPACE_COLOURS, SPACE_LINES, SPACE_MARKERS
from ..builders import evaluation_seeds, navigation_environment
from ..tables.navigation_comparisons import pairs


def draw_task(room: Axes, view: Axes, config: Config) -> None:
    """The room from above at the start of the first evaluation episode, and what the eye sees then."""
    environment = navigation_environment(config)
    seen, _ = environment.reset(seed=evaluation_seeds(config)[0])
    draw_room(room, environment.world)
    for zone in environment.zones:
        name = "goal" if zone.is_goal else "dead zone"
        room.text(
            zone.x,
            zone.y,
            f"{name}\n{zone.reward:+g}",
            ha="center",
            va="center",
            fontsize=8,
            zorder=8,
        )
    draw_view(view, seen)
    view.set_title("what the eye sees", fontsize=8, pad=2)


def _curve(axes: Axes, runs: pd.DataFrame, action_space: str) -> None:
    """Mean with its 95 % interval, and lightly the middle 80 % of the runs."""
    table = runs.pivot(index="step", columns="seed", values="episode_return")
    steps, returns, n = table.index / 1000, table.to_numpy(), table.shape[1]
    mean = returns.mean(axis=1)
    half = stats.t.ppf(0.975, n - 1) * returns.std(axis=1, ddof=1) / np.sqrt(n)
    low, high = np.percentile(returns, [10, 90], axis=1)
    colour = SPACE_COLOURS[action_space]
    axes.fill_between(steps, low, high, color=colour, alpha=0.07, linewidth=0)
    axes.fill_between(steps, mean - half, mean + half, color=colour, alpha=0.25, linewidth=0)
    style = dict(
        color=colour,
        linestyle=SPACE_LINES[action_space],
        marker=SPACE_MARKERS[action_space],
        markersize=3.5,
    )
    axes.plot(steps, mean, linewidth=1.6, label=action_space, **style)


def _dots(axes: Axes, checkpoints: pd.DataFrame, config: Config, top: float, line: float) -> None:
    """A row of dots for each of the paper's pairs, where the difference is significant."""
    for i, (_, a, b) in enumerate(pair for pair in pairs(config) if pair[0] == "paper"):
        rows = checkpoints[
            (checkpoints["a"] == a)
            & (checkpoints["b"] == b)
            & (checkpoints["p_adjusted"] < config.navigation.alpha)
        ]
        y = top - i * line
        for _, row in rows.iterrows():
            better = a if row["difference"] > 0 else b
            axes.plot(
                row["step"] / 1000,
                y,
                marker=SPACE_MARKERS[better],
                markersize=4,
                color=SPACE_COLOURS[better],
            )
        axes.text(
            1.01, y, f"{a} − {b}", fontsize=7.5, va="center", transform=axes.get_yaxis_transform()
        )


@figure(
    title="The navigation task, and what the agents learn with each action space",
    inputs=["navigation_curves", "navigation_checkpoints"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_learning(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    navigation = config.navigation
    curves = tables["navigation_curves"]
    figure = plt.figure(figsize=(12, 5.2))
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.65], height_ratios=[14, 1])
    room, view, axes = (
        figure.add_subplot(grid[0, 0]),
        figure.add_subplot(grid[1, 0]),
        figure.add_subplot(grid[:, 1]),
    )
    draw_task(room, view, config)
    room.set_title("the task: reach the goal, keep out of the dead zones")
    for action_space in navigation.action_spaces:
        _curve(axes, curves[curves["action_space"] == action_space], action_space)
    rewards = [zone.reward for zone in navigation.zones]
    bottom, best = min(rewards), max(rewards)
    line = 0.05 * (best - bottom)
    axes.axhline(navigation.threshold_return, color=GREY, linewidth=0.8, linestyle=":")
    axes.text(
        navigation.steps / 1000,
        navigation.threshold_return,
        "threshold ",
        fontsize=7.5,
        color=GREY,
        va="bottom",
        ha="right",
    )
    _dots(axes, tables["navigation_checkpoints"], config, best + 3.4 * line, line)
    axes.set_ylim(min(-0.05 * best, curves["episode_return"].min()), best + 4 * line)
    axes.set_xlabel("environment steps of training (thousands)")
    axes.set_ylabel("mean return of an evaluation episode")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.86), title="action space")
    axes.set_title(
        f"n = {len(navigation.seeds)} runs each; mean, 95 % interval (dark), middle 80 % of runs (light)\n"
        f"marks on top: checkpoints where the pair differs, in the better one's colour (Welch, Holm, p < {navigation.alpha:g})"
    )
    return figure
