"""Experiments until the order is decided, beside a fixed number of them."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, VERMILION, annotate_above, error_lengths, slant_xticks


@figure(
    title="Sampling until the order is decided",
    inputs=["reset_free_sequential"],
)
def reset_free_sequential(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Left: the share of wrong runs; right: experiments."""
    table = tables["reset_free_sequential"]
    drawn, (left, right) = plt.subplots(1, 2, figsize=(12, 4.2))
    labels = [
        case if protocol == "none" else f"{case}, {protocol}"
        for case, protocol in zip(table["case"], table["protocol"], strict=True)
    ]
    x = np.arange(len(table))
    left.errorbar(
        x, table["error"], yerr=error_lengths(table["error"], table["error"], table["error_high"]),
        fmt="o", color=BLUE, capsize=2,
    )  # fmt: skip
    left.axhline(table["level"].iloc[0], color=VERMILION, linestyle="--", linewidth=1)
    left.set_ylim(0, max(0.06, 1.1 * float(table["error_high"].max())))
    left.set_ylabel("runs in which anything said was wrong")
    left.set_title(f"{int(table['runs'].iloc[0]):,} runs of each case; dashed: the level")
    slant_xticks(left, labels, size=8)
    recorded = table[table["protocol"] != "none"]
    x = np.arange(len(recorded))
    right.bar(x - 0.2, recorded["experiments"], 0.38, color=BLUE, label="until ordered, mean")
    right.bar(x + 0.2, recorded["fixed_experiments"], 0.38, color=GREY,
              label="fixed number, right as often")  # fmt: skip
    for k, row in enumerate(recorded.itertuples()):
        annotate_above(right, k - 0.2, row.experiments, f"{row.share:.0%}", 8)
    right.set_ylabel("experiments, all degrees of freedom")
    right.legend()
    slant_xticks(right, [label for label in labels if label not in ("equal", "margin")], size=8)
    return drawn
