"""Which degrees of freedom commute with which: Philipona's conjecture as a matrix (paper, section II-C)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from ...config import Config
from ...declarations import figure
from ...plotting import DOF_ORDER, dof_label, probability_text
from ..builders import flatland_agent


def _matrix(axes: Axes, table: pd.DataFrame, labels: list[str]) -> AxesImage:
    probability, low, high = (
        table.pivot(index="dof_a", columns="dof_b", values=column)
        .loc[DOF_ORDER, DOF_ORDER]
        .to_numpy()
        for column in ("probability", "ci_low", "ci_high")
    )
    image = axes.imshow(probability, vmin=0, vmax=1, cmap="cividis")
    for (i, j), value in pd.DataFrame(probability).stack().items():
        colour = "black" if value > 0.55 else "white"
        axes.text(
            j,
            i - 0.1,
            probability_text(value, 3),
            ha="center",
            va="center",
            color=colour,
            fontsize=8,
        )
        axes.text(
            j,
            i + 0.25,
            f"±{(high[i, j] - low[i, j]) / 2:.3f}",
            ha="center",
            va="center",
            color=colour,
            fontsize=6,
        )
    axes.set_xticks(range(len(labels)), labels, rotation=45, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(labels)), labels)
    axes.spines[:].set_visible(False)
    return image


@figure(
    title="Which degrees of freedom commute with which: Philipona's conjecture as a matrix",
    inputs=["flatland_commutation"],
    settings=lambda config: config.flatland,
)
def flatland_commutation(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    table, flatland = tables["flatland_commutation"], config.flatland
    still = {
        dof.name
        for dof in flatland_agent(flatland, flatland.reference.agent).dofs
        if not dof.displaces
    }
    labels = [dof_label(dof) + (" *" if dof in still else "") for dof in DOF_ORDER]
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 7.2))
    figure.get_layout_engine().set(rect=(0.0, 0.03, 1.0, 0.94))
    settled = flatland.commutation.settled_world
    titles = {
        flatland.reference.world: "the room as it is: some things move by themselves",
        settled: f"nothing moves by itself, {flatland.commutation.settled_rest_steps} steps of rest",
    }
    for axes, (world, title) in zip((left, right), titles.items(), strict=True):
        image = _matrix(axes, table[table["world"] == world], labels)
        axes.set_title(title, pad=8)
    right.set_yticks([])
    figure.colorbar(
        image, ax=(left, right), label="probability that a then b ends like b then a", shrink=0.8
    )
    figure.suptitle(
        f"Which sequences commute? {table['n'].iloc[0]:,} experiments per pair, threshold 0; ±: half of the 95 % interval\n"
        "diagonal: two different sequences of one degree of freedom; *: displaces nothing",
        fontsize=10,
        y=0.99,
    )
    return figure
