"""Learning curves of PPO with the planar arm, in every action space."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import SPACE_COLOURS, SPACE_LINES
from ..builders import atlas


@figure(
    title="Learning with the planar arm in every action space",
    inputs=["learning_curves"],
    settings=lambda config: atlas(config).learning,
)
def learning_curves(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Mean return and displacement over the runs, with 95 % intervals of the mean."""
    curves, settings = tables["learning_curves"], atlas(config).learning
    drawn, panels = plt.subplots(1, 2, figsize=(9, 3.6))
    labels = {"episode_return": "return of an episode", "displacement": "puck pushed, m"}
    for axes, (column, label) in zip(panels, labels.items(), strict=True):
        for space in settings.action_spaces:
            by_step = curves[curves["action_space"] == space].groupby("step")[column]
            mean, error = by_step.mean(), 1.96 * by_step.std() / np.sqrt(by_step.count())
            colour, thousands = SPACE_COLOURS[space], mean.index / 1000
            axes.plot(thousands, mean, SPACE_LINES[space], color=colour, label=space)
            axes.fill_between(
                thousands, mean - error, mean + error, color=colour, alpha=0.2, linewidth=0
            )
        axes.set_xlabel("training steps, thousands")
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    panels[0].legend(frameon=False, title=f"action space ({settings.seeds} runs each)")
    return drawn
