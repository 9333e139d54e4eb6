"""Which differences the number of runs can detect, and whether the tests reject as often as they
should when there is no difference."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, DARK_GREY, GREY, MEASURE_LABELS, ORANGE, SPACE_COLOURS, slant_xticks
from ..config import NavigationConfig
from ..tables.navigation_calibration import HALVES, RESAMPLED
from ..tables.navigation_comparisons import WELCH
from ..tables.navigation_power import DETECTABLE, POWER, POWER_AT

_MAX_EFFECT = 2.5
"""Largest effect size on the x axis. Chosen: the power is 1 from about there on."""


@figure(
    title="Power of the comparisons, and their rate of false positives",
    inputs=["navigation_power", "navigation_calibration", "navigation_comparisons"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_power(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Power against effect size; rates of rejection in A/A tests of two kinds."""
    navigation, calibration = config.navigation, tables["navigation_calibration"]
    n = len(navigation.seeds)
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 4.6), width_ratios=[1.2, 1, 1])
    _draw_power(left, tables["navigation_power"], navigation)
    _write_observed_effects(left, tables["navigation_comparisons"], navigation)
    left.set_title(f"power with n = {n} runs of each action space; dots: the table", fontsize=9.5)
    top = max(0.1, 1.3 * max(calibration["rate"].max(), calibration["band_high"].max()))
    for axes, method, title in (
        (middle, RESAMPLED, f"A/A: two groups of {n} resampled from the same runs"),
        (right, HALVES, f"A/A: halves of the same {n} runs, {n // 2} each"),
    ):
        _draw_calibration(axes, calibration[calibration["method"] == method], navigation.alpha)
        axes.set_ylim(0, top)
        axes.set_title(
            f"{title}\ngrey: 95 % band if the rate is α; below: number of comparisons", fontsize=9
        )
    return figure


def _draw_power(axes: Axes, power: pd.DataFrame, navigation: NavigationConfig) -> None:
    """Draw the power against the effect size, for the level and for a third of it."""
    from ....statistics.power import power_of_t_test  # imports scipy

    n, level = len(navigation.seeds), navigation.alpha
    effects = np.linspace(0.02, _MAX_EFFECT, 60)
    for alpha, colour, style, name, side in (
        (level, BLUE, "-", f"α = {level:g}", "right"),
        (level / 3, ORANGE, "--", f"α = {level:g} / 3, three pairs", "left"),
    ):
        rows = power[np.isclose(power["alpha"], alpha)]
        powers = [power_of_t_test(d, n, alpha) for d in effects]
        axes.plot(effects, powers, color=colour, linestyle=style, label=name)
        tabulated = rows[rows["question"] == POWER_AT]
        axes.plot(tabulated["effect_size"], tabulated["power"], "o", color=colour, markersize=4)
        detectable = rows.loc[rows["question"] == DETECTABLE, "effect_size"].iloc[0]
        if detectable < _MAX_EFFECT:
            axes.plot([detectable] * 2, [0, POWER], color=colour, linewidth=0.8, linestyle=":")
            axes.text(detectable, 0.02, f" {detectable:.2f} ", fontsize=7.5, color=colour, ha=side)
    axes.axhline(POWER, color=GREY, linewidth=0.8, linestyle=":")
    axes.set_ylim(0, 1.03)
    axes.set_xlim(0, _MAX_EFFECT)
    axes.set_xlabel("true difference of means / standard deviation")
    axes.set_ylabel("probability that Welch's test finds it")
    axes.legend(loc="center right")


def _write_observed_effects(
    axes: Axes, comparisons: pd.DataFrame, navigation: NavigationConfig
) -> None:
    """Write the observed effect sizes of the paper's pairs on the primary measure."""
    rows = comparisons[
        (comparisons["test"] == WELCH)
        & (comparisons["family"] == "paper")
        & (comparisons["measure"] == navigation.primary_measure)
    ]
    lines = [f"observed |g| ({MEASURE_LABELS[navigation.primary_measure]})"]
    for a, b, g in rows[["a", "b", "effect_size"]].itertuples(index=False):
        lines.append(f"{a} − {b}: {abs(g):.2f}")
    axes.text(
        0.98, 0.06, "\n".join(lines), transform=axes.transAxes, fontsize=7.5, ha="right",
        va="bottom",
    )  # fmt: skip


def _draw_calibration(axes: Axes, calibration: pd.DataFrame, level: float) -> None:
    """Draw the rate of rejection of each action space and measure, with its 95 % band."""
    measures = list(dict.fromkeys(calibration["measure"]))
    spaces = list(dict.fromkeys(calibration["action_space"]))
    colours = [SPACE_COLOURS.get(space, BLUE) for space in spaces]
    for i, (measure, marker) in enumerate(zip(measures, "os^v", strict=False)):
        rows = calibration[calibration["measure"] == measure].set_index("action_space").loc[spaces]
        low, height = rows["band_low"], rows["band_high"] - rows["band_low"]
        x = np.arange(len(spaces)) + (i - (len(measures) - 1) / 2) * 0.26
        axes.bar(x, height, bottom=low, width=0.22, color=GREY, alpha=0.3)
        axes.scatter(x, rows["rate"], color=colours, marker=marker, s=30, zorder=3)
        label = MEASURE_LABELS[measure].removesuffix(" (thousands)")
        axes.scatter([], [], color=DARK_GREY, marker=marker, label=label)
    axes.axhline(level, color="black", linewidth=0.8)
    splits = calibration.groupby("action_space", sort=False)["splits"].first()
    slant_xticks(axes, [f"{space}\n{splits[space]:,}" for space in spaces], rotation=30, size=8)
    axes.set_ylabel(f"comparisons with p < {level:g}")
    axes.legend(loc="upper right", fontsize=7.5)
