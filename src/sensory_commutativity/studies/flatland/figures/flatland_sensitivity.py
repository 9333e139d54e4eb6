"""How the SCP depends on the length of the sequences and on the threshold (beyond the paper)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import DOF_COLOURS, DOF_MARKERS, DOF_ORDER, dof_label, set_probability_axis


@figure(
    title="SCP against the length of the sequences and against the threshold",
    inputs=["flatland_sensitivity"],
    settings=lambda config: config.flatland,
)
def flatland_sensitivity(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Curves of every degree of freedom over lengths and over thresholds."""
    table, length = tables["flatland_sensitivity"], config.flatland.sequence_length
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.2), sharey=True)
    _draw_curves(left, table[table["threshold"] == 0], "length")
    lengths = sorted(table["length"].unique())
    left.set_xscale("log")
    left.set_xticks(lengths, [str(n) for n in lengths])
    left.minorticks_off()
    left.axvline(length, color="black", linewidth=0.6, linestyle=":")
    left.set_xlabel("actions in a sequence")
    left.set_title("SCP against sequence length, threshold 0")
    _draw_curves(right, table[table["length"] == length], "threshold")
    right.set_xscale("symlog", linthresh=1)
    right.set_xlim(left=-0.1)
    right.set_xlabel("threshold on the mean squared error (squared 8-bit colour)")
    right.set_ylabel("")
    right.set_title(f"SCP against threshold, {length} actions")
    right.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    where = f"{config.flatland.reference.agent} in the world {config.flatland.reference.world}"
    figure.suptitle(
        f"SCP of {where}; {table['n'].iloc[0]:,} experiments per point, 95 % intervals shaded",
        fontsize=10,
    )
    return figure


def _draw_curves(axes: Axes, table: pd.DataFrame, x: str) -> None:
    """Draw the SCP of every degree of freedom, with its interval, against the column `x`."""
    for k, dof in enumerate(DOF_ORDER):
        rows, colour = table[table["dof"] == dof].sort_values(x), DOF_COLOURS[dof]
        axes.plot(
            rows[x], rows["scp"], marker=DOF_MARKERS[dof], markersize=5, color=colour,
            label=dof_label(dof), linestyle="--" if k % 2 else "-",
        )  # fmt: skip
        axes.fill_between(
            rows[x], rows["ci_low"], rows["ci_high"], color=colour, alpha=0.15, linewidth=0
        )
    set_probability_axis(axes)
