"""Which degrees of freedom commute with which: Philipona's conjecture as a matrix (paper, section II-C)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from ..config import Config
from ..worlds.flatland.from_config import flatland_agent
from .style import DOF_ORDER, dof_label


def draw(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    table = tables["flatland_commutation"]
    matrix = table.pivot(index="dof_a", columns="dof_b", values="probability").loc[DOF_ORDER, DOF_ORDER]
    low = table.pivot(index="dof_a", columns="dof_b", values="ci_low").loc[DOF_ORDER, DOF_ORDER].to_numpy()
    high = table.pivot(index="dof_a", columns="dof_b", values="ci_high").loc[DOF_ORDER, DOF_ORDER].to_numpy()
    still = {dof.name for dof in flatland_agent(config.flatland, config.flatland.reference.agent).dofs if not dof.displaces}
    figure, axes = plt.subplots(figsize=(7.4, 6.4))
    image = axes.imshow(matrix.to_numpy(), vmin=0, vmax=1, cmap="cividis")
    for i in range(len(DOF_ORDER)):
        for j in range(len(DOF_ORDER)):
            value = matrix.iat[i, j]
            colour = "black" if value > 0.55 else "white"
            text = "1" if value == 1 else f"{value:.2f}"
            axes.text(j, i - 0.1, text, ha="center", va="center", color=colour, fontsize=10)
            axes.text(j, i + 0.25, f"±{(high[i, j] - low[i, j]) / 2:.2f}", ha="center", va="center", color=colour, fontsize=6)
    labels = [dof_label(d) + (" *" if d in still else "") for d in DOF_ORDER]
    axes.set_xticks(range(len(labels)), labels, rotation=45, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(labels)), labels)
    axes.spines[:].set_visible(False)
    figure.colorbar(image, ax=axes, label="probability that a then b equals b then a", shrink=0.85)
    axes.set_title(
        f"Which sequences commute? {table['n'].iloc[0]:,} experiments per pair, threshold 0\n"
        "diagonal: two different sequences of one degree of freedom\n* displaces nothing; ±: half of the 95 % interval"
    )
    return figure
