"""Whether the order of the degrees of freedom depends on the threshold, the field of view, the
apartment, the starts and the length of the sequences."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, dof_label, dof_styles
from ..builders import described_files, load_named_robot
from ..claims import THRESHOLDS


@figure(
    title="Whether other settings change the order of the degrees of freedom",
    inputs=["apartment_scp", "apartment_order"],
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_order(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """SCP against the threshold; rank correlation of the reference with each other setting."""
    settings = config.apartment
    reference, view = settings.reference, settings.fields_of_view[0]
    scp = tables["apartment_scp"]
    scp = scp[
        (scp["robot"] == reference.robot)
        & (scp["apartment"] == reference.scene)
        & (scp["start"] == "anywhere")
        & (scp["length"] == settings.sequence_length)
        & (scp["field_of_view"] == view)
    ]
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.8), width_ratios=[1.15, 1])
    _draw_thresholds(left, scp, config)
    left.set_title(
        f"{reference.robot} in {reference.scene}, n = {scp['n'].iloc[0]} for each degree of "
        "freedom; 95 % Wilson intervals",
        fontsize=9,
    )
    _draw_correlations(right, tables["apartment_order"])
    right.set_title(
        f"one setting changed; reference: {reference.scene}, threshold {reference.threshold:g}, "
        f"{view:g} degrees, {settings.sequence_length} actions\n"
        "95 % bootstrap intervals over start situations",
        fontsize=8.5,
    )
    return figure


def _draw_thresholds(axes: Axes, table: pd.DataFrame, config: Config) -> None:
    """Draw the SCP of every degree of freedom, with its interval, against the threshold."""
    settings = config.apartment
    robot = load_named_robot(settings, settings.reference.robot)
    styles, thresholds = dof_styles(robot), settings.thresholds
    x = range(len(thresholds))
    for dof in robot.description.dofs:
        rows = table[table["dof"] == dof.name].set_index("threshold").loc[thresholds]
        style = styles[dof.name]
        axes.plot(x, rows["scp"], label=dof_label(dof.name), markersize=4, **style)
        axes.fill_between(
            x, rows["ci_low"], rows["ci_high"], color=style["color"], alpha=0.08, linewidth=0
        )
    low, high = THRESHOLDS
    if thresholds[0] <= low and thresholds[-1] >= high:
        ends = np.interp([low, high], thresholds, x)
        axes.axvspan(*ends, color=GREY, alpha=0.15, linewidth=0, zorder=0)
    axes.set_xticks(x, [f"{threshold:g}" for threshold in thresholds])
    axes.set_xlabel("threshold: squared distance of VGG16 features (grey: the paper's range)")
    axes.set_ylabel("SCP")
    axes.set_ylim(0, 1.03)
    axes.legend(fontsize=7, ncols=2, loc="lower right")


def _draw_correlations(axes: Axes, table: pd.DataFrame) -> None:
    """Draw Kendall's tau with its interval, a line per changed setting."""
    labels = []
    for y, (_, row) in enumerate(table.iterrows()):
        axes.plot([row["ci_low"], row["ci_high"]], [y, y], color=BLUE, linewidth=1.8)
        axes.plot(row["tau"], y, "o", color=BLUE, markersize=5)
        axes.text(1.04, y, f"{row['tau']:.2f}, n = {row['n']}", va="center", fontsize=7.5)
        labels.append(f"{row['changed']}: {row['value']}")
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) - 0.4, -0.6)
    axes.set_xlim(min(0.0, float(np.nanmin(table["ci_low"])) - 0.05), 1.02)
    axes.axvline(1, color=GREY, linewidth=0.8, linestyle=":")
    axes.axvline(0, color="black", linewidth=0.8)
    axes.set_xlabel("Kendall's tau with the reference order of the degrees of freedom")
