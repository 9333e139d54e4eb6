"""SC-experiments and their alternatives from the same starts: how often a moved object is found,
and whether contact with an immovable object shows (paper, section IV-A, "Alternatives are not
adapted")."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, VERMILION, annotate_above, error_lengths, format_p_value

_NAMES = {
    "sc-experiment": "SC-experiment:\nboth orders",
    "first-last": "first against\nlast picture",
    "return": "back at the start\nafter one order",
}


@figure(
    title="Discoveries of SC-experiments and of their alternatives",
    inputs=["mask_discoveries"],
    settings=lambda config: config.masks,
)
def mask_discoveries(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Discovery rates; true and false positive rates of contact with immovable objects."""
    table = tables["mask_discoveries"]
    table = table[table["kind"] == "random"].reset_index(drop=True)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.8))
    _draw_discoveries(left, table)
    _draw_contacts(right, table)
    labels = [_NAMES[comparison] for comparison in table["comparison"]]
    for axes in (left, right):
        axes.set_xticks(range(len(table)), labels, fontsize=8)
    figure.suptitle(
        f"n = {table['n'].iloc[0]} experiments with random sequences, from the same starts; "
        "95 % intervals: bootstrap over cluttered scenes; predicted by RAFT",
        fontsize=9,
    )
    return figure


def _draw_discoveries(axes: Axes, table: pd.DataFrame) -> None:
    """Draw the discovery rate of each comparison, with the p-value against SC-experiments."""
    rate = table["discovery_rate"].to_numpy()
    axes.bar(range(len(table)), rate, color=VERMILION, width=0.6)
    error = error_lengths(rate, table["ci_low"], table["ci_high"])
    axes.errorbar(range(len(table)), rate, yerr=error, fmt="none", ecolor="#444444", capsize=3)
    for k, row in table.iterrows():
        p = "" if row["comparison"] == "sc-experiment" else f"\n{format_p_value(row['p'])}"
        annotate_above(axes, k, row["ci_high"], f"{row['discovery_rate']:.1f}{p}", 8)
    axes.set_ylabel("experiments in which a moved object\nis found, per hundred")
    axes.set_ylim(0, max(1.0, 1.3 * table["ci_high"].max()))


def _draw_contacts(axes: Axes, table: pd.DataFrame) -> None:
    """Draw how often pairs are predicted as different, with and without contact (TPR and FPR)."""
    for side, kind, colour, label, number in (
        (-1, "tpr", BLUE, "something immovable was touched", "n_touched"),
        (1, "fpr", GREY, "nothing immovable was touched", "n_untouched"),
    ):
        x, rate = np.arange(len(table)) + 0.3 * side / 1.6, table[kind].to_numpy(float)
        label = f"{label} (n = {table[number].iloc[0]})"
        axes.bar(x, rate, color=colour, width=0.34, label=label)
        error = np.nan_to_num(error_lengths(rate, table[f"{kind}_low"], table[f"{kind}_high"]))
        axes.errorbar(x, rate, yerr=error, fmt="none", ecolor="#444444", capsize=3)
    axes.set_ylabel('fraction predicted as "different"')
    axes.set_ylim(0, 1.25)
    axes.legend(loc="upper right", fontsize=8)
