"""The hierarchy of the degrees of freedom as differences of SCP, with intervals and tests (paper,
section III-C)."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREEN, GREY, VERMILION, dof_label, format_p_value
from ..hierarchy import HIERARCHY, LEFT_AND_RIGHT, find_difference

_COLOURS = (BLUE, VERMILION, GREEN, GREY)


@figure(
    title="Differences of SCP between degrees of freedom, with intervals and tests",
    inputs=["flatland_comparisons"],
    settings=lambda config: config.flatland,
)
def flatland_comparisons(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """A forest plot: a line per pair of degrees of freedom, grouped by steps of the hierarchy."""
    comparisons, reference = tables["flatland_comparisons"], config.flatland.reference
    comparisons = comparisons[
        (comparisons["world"] == reference.world) & (comparisons["agent"] == reference.agent)
    ]
    steps = {**HIERARCHY, "left equals right": LEFT_AND_RIGHT}
    figure, axes = plt.subplots(figsize=(8, 5.6))
    y, ticks, n = 0.0, [], 0
    for (name, pairs), colour in zip(steps.items(), _COLOURS, strict=True):
        style: dict[str, Any] = dict(xycoords=("axes fraction", "data"), va="center")
        axes.annotate(name, (0.01, -y), fontweight="bold", color=colour, **style)
        y += 1
        for low, high in pairs:
            pair = find_difference(comparisons, low, high)
            n = pair.n
            axes.plot([pair.ci_low, pair.ci_high], [-y, -y], color=colour, linewidth=2)
            axes.plot(pair.difference, -y, "o", color=colour, markersize=5)
            axes.annotate(format_p_value(pair.p_adjusted), (1.01, -y), fontsize=8, **style)
            ticks.append((-y, f"{dof_label(low)} − {dof_label(high)}"))
            y += 1
        y += 0.4
    axes.axvline(0, color=GREY, linewidth=0.8, linestyle=":")
    axes.set_yticks([t for t, _ in ticks], [label for _, label in ticks])
    axes.set_ylim(-y + 0.4, 0.8)
    axes.set_xlabel("difference of SCP (negative: the first commutes less often)")
    axes.set_title(
        f"Hierarchy of the degrees of freedom, {n:,} shared start situations\n"
        "95 % intervals; exact McNemar tests, Holm-corrected"
    )
    return figure
