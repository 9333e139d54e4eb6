"""SC-experiments and their alternatives on the same starts: what moved is found, and what is immovable shows, or not."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, VERMILION, p_text

_NAMES = {
    "sc-experiment": "SC-experiment:\nboth orders",
    "first-last": "first against\nlast picture",
    "return": "back at the start\nafter one order",
}


@figure(
    title="SC-experiments and their alternatives on the same starts: what moved is found, and what is immovable shows, or not",
    inputs=["mask_discoveries"],
    settings=lambda config: config.masks,
)
def mask_discoveries(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    table = tables["mask_discoveries"]
    table = table[table["kind"] == "random"].reset_index(drop=True)
    names, x = [_NAMES[name] for name in table["comparison"]], np.arange(len(table))
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.8))
    value = table["per_hundred"].to_numpy()
    error = np.maximum(0, [value - table["ci_low"], table["ci_high"] - value])
    left.bar(x, value, color=VERMILION, width=0.6)
    left.errorbar(x, value, yerr=error, fmt="none", ecolor="#444444", capsize=3)
    for k, row in table.iterrows():
        against = "" if row["comparison"] == "sc-experiment" else f"\n{p_text(row['p'])}"
        left.annotate(
            f"{row['per_hundred']:.1f}{against}",
            (k, row["ci_high"]),
            textcoords="offset points",
            xytext=(0, 3),
            ha="center",
            fontsize=8,
        )
    left.set_ylabel("experiments in which a moved object\nis found, per hundred")
    left.set_ylim(0, max(1.0, 1.3 * table["ci_high"].max()))
    for dx, (kind, colour, label, number) in enumerate(
        (
            ("hits", BLUE, "something immovable was touched", "n_touched"),
            ("false_hits", GREY, "nothing immovable was touched", "n_untouched"),
        )
    ):
        value = table[kind].to_numpy(float)
        error = np.maximum(
            0, np.nan_to_num([value - table[f"{kind}_low"], table[f"{kind}_high"] - value])
        )
        right.bar(
            x + 0.3 * (2 * dx - 1) / 1.6,
            value,
            color=colour,
            width=0.34,
            label=f"{label} (n = {table[number].iloc[0]})",
        )
        right.errorbar(
            x + 0.3 * (2 * dx - 1) / 1.6, value, yerr=error, fmt="none", ecolor="#444444", capsize=3
        )
    right.set_ylabel('fraction that is called "different"')
    right.set_ylim(0, 1.25)
    right.legend(loc="upper right", fontsize=8)
    for axes in (left, right):
        axes.set_xticks(x, names, fontsize=8)
    figure.suptitle(
        f"n = {table['n'].iloc[0]} experiments with random sequences, from the same starts; 95 % intervals: bootstrap over households; RAFT decides",
        fontsize=9,
    )
    return figure
