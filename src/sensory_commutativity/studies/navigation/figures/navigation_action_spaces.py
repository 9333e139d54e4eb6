"""The action spaces that are made from the measured SCPs (paper, section IV-B)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import DOF_ORDER, dof_label


@figure(
    title="Scale of every degree of freedom in every action space",
    inputs=["navigation_action_spaces"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_action_spaces(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A matrix of the factors by which the intervals of actions are scaled."""
    table, spaces = tables["navigation_action_spaces"], config.navigation.action_spaces
    scp = table.drop_duplicates("dof").set_index("dof")["scp"]
    mean = table.groupby(["action_space", "dof"])["scale"].mean().unstack().loc[spaces, DOF_ORDER]
    figure, axes = plt.subplots(figsize=(9, 0.55 * len(spaces) + 2.4))
    image = axes.imshow(mean, vmin=0, vmax=1, cmap="cividis", aspect="auto")
    for (i, j), value in np.ndenumerate(mean):
        colour = "white" if value < 0.55 else "black"
        axes.text(j, i, f"{value:.2f}", ha="center", va="center", color=colour, fontsize=8)
    labels = [f"{dof_label(dof, lines=True)}\nSCP {scp[dof]:.3f}" for dof in DOF_ORDER]
    axes.set_xticks(range(len(DOF_ORDER)), labels, fontsize=8)
    axes.set_yticks(range(len(spaces)), spaces)
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)
    axes.set_title(
        "factor of each degree of freedom's action interval (0: fixed, 1: whole)\n"
        f"random-half: mean over its {len(config.navigation.seeds)} runs, each of which draws its "
        "own half",
    )
    figure.colorbar(image, label="factor")
    return figure
