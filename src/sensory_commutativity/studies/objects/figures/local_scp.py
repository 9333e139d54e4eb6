"""The local SCP over the floor of an apartment, beside its plan and the distance to what is in
reach (paper, Fig. "SCP map")."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Wedge

from ...apartment.builders import apartment_world, described_files
from ...config import Config
from ...declarations import figure
from ...plotting import dof_label
from ..config import MapConfig

MARGIN = 0.7
"""Metres around the poses that are shown. Chosen: walls and furniture next to the poses."""


@figure(
    title="Map of the local SCP in an apartment, beside its plan and the true distances",
    inputs=["local_scp", "local_scp_summary"],
    settings=lambda config: [config.masks, config.apartment, described_files(config)],
)
def local_scp(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """The plan, the map of the local SCP, and the map of true distances."""
    from ....worlds.apartment.rendering.drawing import render_plan  # imports PyBullet

    table, settings, robot = tables["local_scp"], config.masks.map, config.masks.robot
    reach = config.apartment.reach  # beyond it, space counts as open
    dof = dof_label(table["dof"].iloc[0]) if len(table) else "arm"
    world = apartment_world(config, robot, settings.scene, "anywhere")
    plan, extent = render_plan(world.simulation)
    world.simulation.close()
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(17, 5), width_ratios=[0.75, 1, 1])
    titles = (
        settings.scene,
        f"local SCP of {robot}'s {dof}: {settings.experiments} SC-experiments of "
        f"{settings.sequence_length} steps;\n"
        "a wedge for each heading, none where there is no room to stand",
        "truth: metres from the swept arm to the nearest\n"
        "immovable object, below 0 where the arm would be inside it",
    )
    for axes, title in zip((left, middle, right), titles, strict=True):
        axes.imshow(plan, extent=extent, alpha=1.0 if axes is left else 0.35)
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("metres")
    left.set_ylabel("metres")
    for axes in (middle, right) if len(table) else ():
        axes.set_xlim(table["x"].min() - MARGIN, table["x"].max() + MARGIN)
        axes.set_ylim(table["y"].min() - MARGIN, table["y"].max() + MARGIN)
    _draw_map(middle, table, "scp", (0, 1), settings, "local SCP")
    _draw_map(right, table, "clearance", (-reach, reach), settings, "metres")
    figure.suptitle(_summary_text(tables["local_scp_summary"]), fontsize=8.5)
    return figure


def _draw_map(
    axes: Axes,
    table: pd.DataFrame,
    column: str,
    limits: tuple[float, float],
    settings: MapConfig,
    label: str,
) -> None:
    """Draw a wedge per pose, in the direction of the robot's heading, with colours in `limits`."""
    half = 180 / settings.headings
    wedges = [
        Wedge((x, y), 0.48 * settings.spacing, degrees - half, degrees + half)
        for x, y, degrees in zip(table["x"], table["y"], np.degrees(table["heading"]), strict=True)
    ]
    patches = PatchCollection(wedges, cmap="cividis", edgecolor="white", linewidth=0.2)
    patches.set_array(table[column].to_numpy(float))
    patches.set_clim(*limits)
    axes.add_collection(patches)
    extend = "both" if column == "clearance" else "neither"
    axes.figure.colorbar(patches, ax=axes, label=label, shrink=0.8, extend=extend)


def _summary_text(summary: pd.DataFrame) -> str:
    """Estimates with intervals of the experiments whose outcomes the mask predictor decided."""
    texts = []
    for _, row in summary[(summary["decided_by"] == "predictor") & (summary["n"] > 0)].iterrows():
        name = "area under the ROC curve" if row["measure"] == "auc" else f"median, {row['where']}"
        texts.append(
            f"{name}: {row['estimate']:.2f} [{row['ci_low']:.2f}, {row['ci_high']:.2f}] "
            f"(n = {int(row['n'])})"
        )
    return "; ".join(texts)
