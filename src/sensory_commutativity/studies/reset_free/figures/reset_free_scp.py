"""The SCP of every degree of freedom by the return protocol, beside the true one."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, ORANGE, VERMILION, dof_label, error_lengths, slant_xticks
from ..builders import apartment_runs, trial_runs
from ..estimates import QUIET

SERIES = {
    "reset": ("restored start", "scp", GREY, "s"),
    "return": ("return protocol", "scp", BLUE, "o"),
    "relative": ("return protocol, relative to its control", "relative", VERMILION, "^"),
    QUIET: ("the same, at starts where nothing moves", "relative", ORANGE, "v"),
}
"""Series -> label, column, colour and marker."""


@figure(
    title="SCP without a reset",
    inputs=["reset_free_scp", "reset_free_agreement"],
    settings=lambda config: config.apartment.reference.threshold,
)
def reset_free_scp(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A panel per world."""
    worlds = [*trial_runs(config), *apartment_runs(config)]
    columns = 2
    lines = -(-len(worlds) // columns)
    drawn, grid = plt.subplots(
        lines, columns, figsize=(11, 3.1 * lines + 0.5), squeeze=False, sharey=True
    )
    for axes in grid.ravel()[len(worlds) :]:
        axes.set_visible(False)
    for axes, world in zip(grid.ravel(), worlds, strict=False):
        apartment = world in apartment_runs(config)
        threshold = config.apartment.reference.threshold if apartment else 0.0
        scp, agreement = tables["reset_free_scp"], tables["reset_free_agreement"]
        rows = scp[(scp["world"] == world) & (scp["threshold"] == threshold)]
        _draw(axes, rows)
        spearman = agreement.loc[agreement["world"] == world, "spearman"].iloc[0]
        n = int(rows["n"].max())
        axes.set_title(
            f"{world}: n = {n:,}, threshold {threshold:g}, rank correlation "
            f"{'not defined' if np.isnan(spearman) else f'{spearman:.2f}'}"
        )
    for axes in grid[:, 0]:
        axes.set_ylabel("SCP")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper center", ncol=4)
    return drawn


def _draw(axes: Axes, rows: pd.DataFrame) -> None:
    dofs = list(rows["dof"].unique())
    for shift, (series, (label, column, colour, marker)) in enumerate(SERIES.items()):
        chosen = rows[rows["protocol"] == ("return" if series == "relative" else series)]
        if not len(chosen):
            continue
        ends = ("relative_low", "relative_high") if column == "relative" else ("ci_low", "ci_high")
        low, high = ends
        axes.errorbar(
            np.arange(len(dofs)) + 0.2 * (shift - 1.5), chosen[column],
            yerr=error_lengths(chosen[column], chosen[low], chosen[high]),
            fmt=marker, color=colour, markersize=4.5, capsize=2, label=label,
        )  # fmt: skip
    slant_xticks(axes, [dof_label(dof) for dof in dofs])
    axes.axhline(1, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
    axes.set_ylim(0, 1.19)
