"""Performance profiles: the fraction of runs that end with at least a given return (Agarwal et al.,
2021, Deep Reinforcement Learning at the Edge of the Statistical Precipice)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import GREY, SPACE_COLOURS, SPACE_LINES


@figure(
    title="Performance profiles: fraction of runs that end with at least a given return",
    inputs=["navigation_profiles"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_profiles(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A curve per action space."""
    navigation, profiles = config.navigation, tables["navigation_profiles"]
    figure, axes = plt.subplots(figsize=(7.6, 4.4))
    for action_space in navigation.action_spaces:
        rows = profiles[profiles["action_space"] == action_space]
        x, colour = rows["threshold"], SPACE_COLOURS[action_space]
        axes.fill_between(x, rows["ci_low"], rows["ci_high"], color=colour, alpha=0.1, linewidth=0)
        axes.plot(
            x, rows["fraction"], color=colour, linestyle=SPACE_LINES[action_space], linewidth=1.8,
            label=action_space,
        )  # fmt: skip
    threshold = navigation.threshold_return
    axes.axvline(threshold, color=GREY, linewidth=0.8, linestyle=":")
    axes.text(threshold, 1.03, "threshold return", fontsize=7.5, color=GREY, ha="center")
    axes.set_ylim(0, 1.08)
    axes.set_xlabel("return at the last evaluation")
    axes.set_ylabel("fraction of runs with at least this return")
    axes.set_title(
        f"Performance profiles, n = {len(navigation.seeds)} runs each, pointwise 95 % Wilson "
        "intervals"
    )
    axes.legend(title="action space", loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure
