"""The local SCP over the floor of an apartment, beside its plan and what truly is in reach (paper, Fig. "SCP map")."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Wedge

from ....worlds.apartment.rendering.drawing import render_plan
from ...apartment.builders import apartment_world, described_files
from ...config import Config
from ...declarations import figure
from ...plotting import dof_label
from ..config import MapConfig

_MARGIN = 0.7  # metres around the places that are shown


def _map(
    axes: Axes,
    table: pd.DataFrame,
    column: str,
    limits: tuple[float, float],
    settings: MapConfig,
    label: str,
) -> None:
    """A wedge for every place and heading, in the direction in which the robot faces; colours between `limits`."""
    half = 180 / settings.headings
    wedges = [
        Wedge((x, y), 0.48 * settings.spacing, degrees - half, degrees + half)
        for x, y, degrees in zip(table["x"], table["y"], np.degrees(table["heading"]), strict=True)
    ]
    shown = PatchCollection(wedges, cmap="cividis", edgecolor="white", linewidth=0.2)
    shown.set_array(table[column].to_numpy(float))
    shown.set_clim(*limits)
    axes.add_collection(shown)
    extend = "both" if column == "clearance" else "neither"
    axes.figure.colorbar(shown, ax=axes, label=label, shrink=0.8, extend=extend)


@figure(
    title="The local SCP over the floor of an apartment, beside its plan and what truly is in reach",
    inputs=["local_scp", "local_scp_summary"],
    settings=lambda config: [config.masks, config.apartment, described_files(config)],
)
def local_scp(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    table, summary = tables["local_scp"], tables["local_scp_summary"]
    reach = config.apartment.reach  # beyond it space counts as open
    settings, dof = config.masks.map, dof_label(table["dof"].iloc[0]) if len(table) else "arm"
    world = apartment_world(config, config.masks.robot, settings.scene, "anywhere")
    picture, extent = render_plan(world.simulation)
    world.simulation.close()
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(17, 5), width_ratios=[0.75, 1, 1])
    for axes, title in (
        (left, settings.scene),
        (
            middle,
            f"local SCP of {config.masks.robot}'s {dof}: {settings.experiments} SC-experiments of {settings.sequence_length} steps;\n"
            "a wedge for each heading, none where there is no room to stand",
        ),
        (
            right,
            "truth: metres from the swept arm to the nearest\nimmovable thing, below 0 where it would be inside",
        ),
    ):
        axes.imshow(picture, extent=extent, alpha=1.0 if axes is left else 0.35)
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("metres")
    left.set_ylabel("metres")
    for axes in (middle, right) if len(table) else ():
        axes.set_xlim(table["x"].min() - _MARGIN, table["x"].max() + _MARGIN)
        axes.set_ylim(table["y"].min() - _MARGIN, table["y"].max() + _MARGIN)
    _map(middle, table, "scp", (0, 1), settings, "local SCP")
    _map(right, table, "clearance", (-reach, reach), settings, "metres")
    said = []
    for _, row in summary[(summary["decided_by"] == "predictor") & (summary["n"] > 0)].iterrows():
        name = "area under the ROC curve" if row["measure"] == "auc" else f"median, {row['where']}"
        said.append(
            f"{name}: {row['estimate']:.2f} [{row['ci_low']:.2f}, {row['ci_high']:.2f}] (n = {int(row['n'])})"
        )
    figure.suptitle("; ".join(said), fontsize=8.5)
    return figure
