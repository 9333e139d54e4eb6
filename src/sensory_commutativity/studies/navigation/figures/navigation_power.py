"""Which differences would these numbers of runs find, and do the tests err as often as they should?"""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....statistics.power import power_of_t_test
from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREY, MEASURE_LABELS, ORANGE, SPACE_COLOURS
from ..config import NavigationConfig
from ..tables.navigation_calibration import HALVES, RESAMPLED
from ..tables.navigation_comparisons import WELCH
from ..tables.navigation_power import DETECTABLE, POWER, POWER_AT

_WIDEST = 2.5


def _power(
    axes: Axes, power: pd.DataFrame, comparisons: pd.DataFrame, navigation: NavigationConfig
) -> None:
    n, level, primary = len(navigation.seeds), navigation.alpha, navigation.primary_measure
    effects = np.linspace(0.02, _WIDEST, 60)
    lines = (
        (level, BLUE, "-", f"α = {level:g}", "right"),
        (level / 3, ORANGE, "--", f"α = {level:g} / 3, three pairs", "left"),
    )
    for alpha, colour, style, name, side in lines:
        rows = power[np.isclose(power["alpha"], alpha)]
        axes.plot(
            effects,
            [power_of_t_test(d, n, alpha) for d in effects],
            color=colour,
            linestyle=style,
            label=name,
        )
        at = rows[rows["question"] == POWER_AT]
        axes.plot(at["effect_size"], at["power"], "o", color=colour, markersize=4)
        found = rows[rows["question"] == DETECTABLE].iloc[0]
        if found["effect_size"] < _WIDEST:
            axes.plot(
                [found["effect_size"]] * 2, [0, POWER], color=colour, linewidth=0.8, linestyle=":"
            )
            axes.text(
                found["effect_size"],
                0.02,
                f" {found['effect_size']:.2f} ",
                fontsize=7.5,
                color=colour,
                ha=side,
            )
    welch = comparisons[
        (comparisons["test"] == WELCH)
        & (comparisons["family"] == "paper")
        & (comparisons["measure"] == primary)
    ]
    notes = [
        f"observed |g| ({MEASURE_LABELS[primary]})",
        *(f"{row['a']} − {row['b']}: {abs(row['effect_size']):.2f}" for _, row in welch.iterrows()),
    ]
    axes.text(
        0.98,
        0.06,
        "\n".join(notes),
        transform=axes.transAxes,
        fontsize=7.5,
        ha="right",
        va="bottom",
    )
    axes.axhline(POWER, color=GREY, linewidth=0.8, linestyle=":")
    axes.set_ylim(0, 1.03)
    axes.set_xlim(0, _WIDEST)
    axes.set_xlabel("true difference of means / standard deviation")
    axes.set_ylabel("probability that Welch's test finds it")
    axes.set_title(f"power with n = {n} runs of each action space; dots: the table", fontsize=9.5)
    axes.legend(loc="center right")


def _calibration(
    axes: Axes, calibration: pd.DataFrame, level: float, top: float, title: str
) -> None:
    measures = list(dict.fromkeys(calibration["measure"]))
    spaces = list(dict.fromkeys(calibration["action_space"]))
    for i, measure in enumerate(measures):
        rows = calibration[calibration["measure"] == measure].set_index("action_space").loc[spaces]
        places = np.arange(len(spaces)) + (i - (len(measures) - 1) / 2) * 0.26
        axes.bar(
            places,
            rows["band_high"] - rows["band_low"],
            bottom=rows["band_low"],
            width=0.22,
            color=GREY,
            alpha=0.3,
        )
        colours = [SPACE_COLOURS.get(space, BLUE) for space in spaces]
        axes.scatter(places, rows["rate"], color=colours, marker="os^v"[i], s=30, zorder=3)
        axes.scatter(
            [],
            [],
            color="#555555",
            marker="os^v"[i],
            label=MEASURE_LABELS[measure].removesuffix(" (thousands)"),
        )
    axes.axhline(level, color="black", linewidth=0.8)
    splits = calibration.groupby("action_space", sort=False)["splits"].first()
    names = [f"{space}\n{splits[space]:,}" for space in spaces]
    axes.set_xticks(
        range(len(spaces)), names, fontsize=8, rotation=30, ha="right", rotation_mode="anchor"
    )
    axes.set_ylim(0, top)
    axes.set_ylabel(f"comparisons with p < {level:g}")
    axes.set_title(title, fontsize=9)
    axes.legend(loc="upper right", fontsize=7.5)


@figure(
    title="Which differences would these numbers of runs find, and do the tests err as often as they should?",
    inputs=["navigation_power", "navigation_calibration", "navigation_comparisons"],
    settings=lambda config: [config.flatland, config.navigation],
)
def navigation_power(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    figure, (left, *right) = plt.subplots(1, 3, figsize=(15, 4.6), width_ratios=[1.2, 1, 1])
    n = len(config.navigation.seeds)
    calibration = tables["navigation_calibration"]
    top = max(0.1, 1.3 * max(calibration["rate"].max(), calibration["band_high"].max()))
    titles = {
        RESAMPLED: f"A/A: two groups of {n} resampled from the same runs",
        HALVES: f"A/A: halves of the same {n} runs, {n // 2} each",
    }
    _power(left, tables["navigation_power"], tables["navigation_comparisons"], config.navigation)
    for axes, (method, title) in zip(right, titles.items(), strict=True):
        rows = calibration[calibration["method"] == method]
        _calibration(
            axes,
            rows,
            config.navigation.alpha,
            top,
            f"{title}\ngrey: 95 % band if the rate is α; below: number of comparisons",
        )
    return figure
