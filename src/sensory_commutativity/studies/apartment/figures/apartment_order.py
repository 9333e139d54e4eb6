"""Do thresholds, fields of view, apartments, lengths and starts change the order of the degrees of freedom?"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....worlds.apartment.robots.robot import load_robot
from ...apartment.builders import described_files
from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, dof_label, dof_styles


def _sweep(axes: Axes, table: pd.DataFrame, config: Config) -> None:
    settings = config.apartment
    robot = load_robot(settings.robots[settings.reference.robot].description)
    styles = dof_styles(robot)
    thresholds = settings.thresholds
    for dof in robot.description.dofs:
        rows = table[table["dof"] == dof.name].set_index("threshold").loc[thresholds]
        axes.plot(
            range(len(thresholds)),
            rows["scp"],
            label=dof_label(dof.name),
            markersize=4,
            **styles[dof.name],
        )
        axes.fill_between(
            range(len(thresholds)),
            rows["ci_low"],
            rows["ci_high"],
            color=styles[dof.name]["color"],
            alpha=0.08,
            linewidth=0,
        )
    if thresholds[0] <= 20 and thresholds[-1] >= 100:
        axes.axvspan(
            *(np.interp([20, 100], thresholds, range(len(thresholds)))),
            color=GREY,
            alpha=0.15,
            linewidth=0,
            zorder=0,
        )
    axes.set_xticks(range(len(thresholds)), [f"{threshold:g}" for threshold in thresholds])
    axes.set_xlabel("threshold: squared distance of VGG16 features (grey: the paper's range)")
    axes.set_ylabel("SCP")
    axes.set_ylim(0, 1.03)
    axes.legend(fontsize=7, ncols=2, loc="lower right")


def _taus(axes: Axes, table: pd.DataFrame) -> None:
    for y, (_, row) in enumerate(table.iterrows()):
        axes.plot([row["ci_low"], row["ci_high"]], [y, y], color=BLUE, linewidth=1.8)
        axes.plot(row["tau"], y, "o", color=BLUE, markersize=5)
        axes.text(1.04, y, f"{row['tau']:.2f}, n = {row['n']}", va="center", fontsize=7.5)
    axes.set_yticks(
        range(len(table)), [f"{row['changed']}: {row['value']}" for _, row in table.iterrows()]
    )
    axes.set_ylim(len(table) - 0.4, -0.6)
    axes.set_xlim(min(0.0, float(np.nanmin(table["ci_low"])) - 0.05), 1.02)
    axes.axvline(1, color=GREY, linewidth=0.8, linestyle=":")
    axes.axvline(0, color="black", linewidth=0.8)
    axes.set_xlabel("Kendall's tau of the degrees of freedom's order with the reference")


@figure(
    title="Do thresholds, fields of view, apartments, lengths and starts change the order of the degrees of freedom?",
    inputs=["apartment_scp", "apartment_order"],
    settings=lambda config: [config.apartment, described_files(config)],
)
def apartment_order(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    settings = config.apartment
    reference = settings.reference
    scp = tables["apartment_scp"]
    chosen = (
        (scp["robot"] == reference.robot)
        & (scp["apartment"] == reference.scene)
        & (scp["start"] == "anywhere")
    )
    chosen &= (scp["length"] == settings.sequence_length) & (
        scp["field_of_view"] == settings.fields_of_view[0]
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 4.8), width_ratios=[1.15, 1])
    _sweep(left, scp[chosen], config)
    left.set_title(
        f"{reference.robot} in {reference.scene}, n = {scp[chosen]['n'].iloc[0]} for each degree of freedom; 95 % Wilson intervals",
        fontsize=9,
    )
    _taus(right, tables["apartment_order"])
    right.set_title(
        f"one setting changed; reference: {reference.scene}, threshold {reference.threshold:g}, {settings.fields_of_view[0]:g} degrees, "
        f"{settings.sequence_length} actions\n95 % bootstrap intervals over start situations",
        fontsize=8.5,
    )
    return figure
