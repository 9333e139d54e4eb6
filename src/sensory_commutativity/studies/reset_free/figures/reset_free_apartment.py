"""The return protocol of a robot in an apartment, with corrections of the return."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREEN, GREY, VERMILION, dof_label, error_lengths, slant_xticks
from ..builders import apartment_runs
from ..tables.reset_free_corrections import CORRECTIONS

COLOURS = dict(zip(CORRECTIONS, (BLUE, VERMILION, GREEN), strict=True))


@figure(
    title="Return protocol in apartments, with corrections",
    inputs=["reset_free_corrections"],
)
def reset_free_apartment(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A row per run: SCPs, and how often the trials are decided as with a restored start."""
    runs = list(apartment_runs(config))
    drawn, grid = plt.subplots(len(runs), 2, figsize=(12, 3.6 * len(runs) + 0.4), squeeze=False)
    for (left, right), run in zip(grid, runs, strict=True):
        rows = tables["reset_free_corrections"]
        rows = rows[rows["world"] == run]
        dofs = list(rows["dof"].unique())
        x = np.arange(len(dofs))
        true = rows[rows["correction"] == "none"]
        left.plot(x - 0.3, true["true_scp"], "s", color=GREY, label="restored start")
        for k, (correction, colour) in enumerate(COLOURS.items()):
            one = rows[rows["correction"] == correction]
            left.errorbar(
                x + 0.2 * (k - 0.5), one["scp"],
                yerr=error_lengths(one["scp"], one["ci_low"], one["ci_high"]),
                fmt="o", color=colour, markersize=4, capsize=2, label=f"return, {correction}",
            )  # fmt: skip
            right.bar(x + 0.27 * (k - 1), one["agreement"], 0.25, color=colour)
        for axes, label in ((left, "SCP"), (right, "trials decided alike")):
            slant_xticks(axes, [dof_label(dof) for dof in dofs])
            axes.set_ylim(0, 1.05)
            axes.set_ylabel(label)
        moved = int(true["moved"].sum())
        left.set_title(f"{run}: n = {int(true['n'].iloc[0]):,} of each degree of freedom")
        right.set_title(f"the first return did not lead the base back in {moved:,} trials")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper center", ncol=4)
    return drawn
