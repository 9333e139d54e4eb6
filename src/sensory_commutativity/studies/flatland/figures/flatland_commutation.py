"""Which degrees of freedom commute with which: Philipona's conjecture as a matrix (paper, section
II-C)."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from ...config import Config
from ...declarations import figure
from ...plotting import DOF_ORDER, dof_label, format_probability, slant_xticks
from ..builders import flatland_agent


@figure(
    title="How often each pair of degrees of freedom commutes",
    inputs=["flatland_commutation"],
    settings=lambda config: config.flatland,
)
def flatland_commutation(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A matrix for the reference room and one for a room without moving objects."""
    table, flatland = tables["flatland_commutation"], config.flatland
    dofs = flatland_agent(flatland, flatland.reference.agent).dofs
    still = {dof.name for dof in dofs if not dof.displaces}
    labels = [dof_label(dof) + (" *" if dof in still else "") for dof in DOF_ORDER]
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 7.2))
    figure.set_layout_engine("constrained", rect=(0.0, 0.03, 1.0, 0.94))
    settled = flatland.commutation
    image = _draw_matrix(left, table[table["world"] == flatland.reference.world], labels)
    left.set_title("the room as it is: some objects move by themselves", pad=8)
    _draw_matrix(right, table[table["world"] == settled.settled_world], labels)
    right.set_title(f"nothing moves by itself, {settled.settled_rest_steps} steps of rest", pad=8)
    right.set_yticks([])
    figure.colorbar(
        image, ax=(left, right), label="probability that a then b ends like b then a", shrink=0.8
    )
    figure.suptitle(
        f"Which sequences commute? {table['n'].iloc[0]:,} experiments per pair, threshold 0; "
        "±: half of the 95 % interval\n"
        "diagonal: two different sequences of one degree of freedom; *: displaces nothing",
        fontsize=10,
        y=0.99,
    )
    return figure


def _draw_matrix(axes: Axes, table: pd.DataFrame, labels: list[str]) -> AxesImage:
    probability, low, high = (
        table.pivot(index="dof_a", columns="dof_b", values=column)
        .loc[DOF_ORDER, DOF_ORDER]
        .to_numpy()
        for column in ("probability", "ci_low", "ci_high")
    )
    image = axes.imshow(probability, vmin=0, vmax=1, cmap="cividis")
    for (i, j), value in pd.DataFrame(probability).stack().items():
        colour = "black" if value > 0.55 else "white"
        style: dict[str, Any] = dict(ha="center", va="center", color=colour)
        half = f"±{(high[i, j] - low[i, j]) / 2:.3f}"
        axes.text(j, i - 0.1, format_probability(value, 3), fontsize=8, **style)
        axes.text(j, i + 0.25, half, fontsize=6, **style)
    slant_xticks(axes, labels)
    axes.set_yticks(range(len(labels)), labels)
    axes.spines[:].set_visible(False)
    return image
