"""The local SCP over the floor of an apartment, beside its plan and what truly is in reach (paper, Fig. "SCP map")."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..config import Config
from ..worlds.apartment.drawing import plan
from ..worlds.apartment.from_config import apartment_world
from .style import dof_label

_SCALE = {"scp": (0, 1), "clearance": (-0.2, 1)}


def _map(axes: Axes, table: pd.DataFrame, column: str, spacing: float, label: str) -> None:
    """Mean over headings at every place, as squares; dots show each heading's own value."""
    low, high = _SCALE[column]
    places = table.groupby(["x", "y"], as_index=False)[column].mean()
    size = spacing * 0.92
    norm, colours = plt.Normalize(low, high), plt.get_cmap("cividis")
    for _, row in places.iterrows():
        axes.add_patch(plt.Rectangle((row["x"] - size / 2, row["y"] - size / 2), size, size, color=colours(norm(row[column])), linewidth=0))
    for _, row in table.iterrows():
        ahead = spacing * 0.3 * np.array([np.cos(row["heading"]), np.sin(row["heading"])])
        end = row["x"] + ahead[0], row["y"] + ahead[1]
        axes.plot(*end, marker="o", markersize=3.2, color=colours(norm(row[column])), markeredgecolor="white", markeredgewidth=0.4)
    axes.figure.colorbar(plt.cm.ScalarMappable(norm, colours), ax=axes, label=label, shrink=0.8)


def draw(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    table, summary = tables["local_scp"], tables["local_scp_summary"]
    settings, dof = config.masks.map, dof_label(table["dof"].iloc[0]) if len(table) else "arm"
    world = apartment_world(config, config.masks.robot, settings.scene, "anywhere")
    picture, extent = plan(world.simulation)
    world.simulation.close()
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(16, 5.4))
    for axes, title in (
        (left, settings.scene),
        (
            middle,
            f"local SCP of {config.masks.robot}'s {dof}: {settings.experiments} SC-experiments of\n"
            f"{settings.sequence_length} steps for each heading (dots); squares: their mean;\nnone: no room to stand",
        ),
        (right, "truth: metres from the swept arm to the\nnearest immovable thing, below 0 inside it"),
    ):
        axes.imshow(picture, extent=extent, alpha=1.0 if axes is left else 0.35)
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("metres")
    left.set_ylabel("metres")
    _map(middle, table, "scp", settings.spacing, "local SCP")
    _map(right, table, "clearance", settings.spacing, "metres")
    said = []
    for _, row in summary[summary["decided_by"] == "predictor"].iterrows():
        name = "area under the ROC curve" if row["measure"] == "auc" else f"median, {row['where']}"
        said.append(f"{name}: {row['estimate']:.2f} [{row['ci_low']:.2f}, {row['ci_high']:.2f}] (n = {int(row['n'])})")
    figure.suptitle("; ".join(said), fontsize=8.5)
    return figure
