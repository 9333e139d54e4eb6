"""The SCP of every degree of freedom against noise, with and without a calibrated threshold."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import DOF_COLOURS, DOF_MARKERS, DOF_ORDER, dof_label, error_lengths
from ..noise import noise_runs
from ..tables.reset_free_noise import THRESHOLDS

LABELS = {
    "sensor": "noise of each colour (of 255)",
    "actuator": "noise of a motion, share of it",
    "reset": "noise of the start pose, actions of 1",
}


@figure(
    title="SCP under noise",
    inputs=["reset_free_noise", "reset_free_noise_order"],
    settings=lambda config: list(noise_runs(config)),
)
def reset_free_noise(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A row per threshold and one for Kendall's tau, a column per kind of noise and protocol."""
    runs = noise_runs(config)
    drawn, grid = plt.subplots(3, len(runs), figsize=(14, 8), sharey="row", squeeze=False)
    for column, run in enumerate(runs.values()):
        for line, threshold in enumerate(THRESHOLDS):
            rows = _select(tables["reset_free_noise"], run.noise, run.protocol)
            _draw_scp(grid[line, column], rows[rows["threshold"] == threshold])
        rows = _select(tables["reset_free_noise_order"], run.noise, run.protocol)
        _draw_tau(grid[2, column], rows)
        grid[0, column].set_title(f"{run.noise}, {run.protocol} protocol")
        grid[2, column].set_xlabel(LABELS[run.noise])
    for line, label in enumerate(("SCP at threshold 0", "SCP, calibrated", "Kendall's tau")):
        grid[line, 0].set_ylabel(label)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper center", ncol=len(DOF_ORDER))
    return drawn


def _select(table: pd.DataFrame, noise: str, protocol: str) -> pd.DataFrame:
    return table[(table["noise"] == noise) & (table["protocol"] == protocol)]


def _ticks(axes: Axes, levels: np.ndarray) -> None:
    axes.set_xticks(range(len(levels)), [f"{level:g}" for level in levels])


def _draw_scp(axes: Axes, rows: pd.DataFrame) -> None:
    levels = rows["level"].unique()
    for k, dof in enumerate(DOF_ORDER):
        one = rows[rows["dof"] == dof]
        axes.errorbar(
            np.arange(len(levels)) + 0.03 * (k - 3.5), one["scp"],
            yerr=error_lengths(one["scp"], one["ci_low"], one["ci_high"]),
            color=DOF_COLOURS[dof], marker=DOF_MARKERS[dof], markersize=3.5, linewidth=1,
            label=dof_label(dof),
        )  # fmt: skip
    _ticks(axes, levels)
    axes.set_ylim(-0.03, 1.05)


def _draw_tau(axes: Axes, rows: pd.DataFrame) -> None:
    for shift, (threshold, style) in enumerate(zip(THRESHOLDS, (":", "-"), strict=True)):
        one = rows[rows["threshold"] == threshold]
        axes.errorbar(
            np.arange(len(one)) + 0.06 * shift, one["tau"],
            yerr=error_lengths(one["tau"], one["ci_low"], one["ci_high"]),
            color="black", linestyle=style, marker="o", markersize=3.5,
            label="threshold 0" if threshold == "0" else "calibrated threshold",
        )  # fmt: skip
    _ticks(axes, rows["level"].unique())
    axes.axhline(0, color="#8A8A8A", linewidth=0.8, linestyle=":", zorder=0)
    axes.set_ylim(-0.65, 1.08)
    axes.legend(fontsize=7, loc="lower left")
