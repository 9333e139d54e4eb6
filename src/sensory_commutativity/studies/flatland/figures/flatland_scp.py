"""SCP of every degree of freedom, and the two alternatives that the paper tried (paper, Fig. "SCP
per degree of freedom", and appendix A)."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import (
    DOF_ORDER,
    draw_dof_bars,
    format_p_value,
    select_reference,
    set_probability_axis,
)


@figure(
    title="SCP of every degree of freedom, beside naive change and prediction error",
    inputs=["flatland_scp", "flatland_baselines", "flatland_alternatives"],
    settings=lambda config: config.flatland,
)
def flatland_scp(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Bars of the SCP and of both alternatives."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4.4))
    scp = select_reference(tables["flatland_scp"], config)
    draw_dof_bars(left, scp["scp"], scp["ci_low"], scp["ci_high"], digits=3)
    set_probability_axis(left, "SCP at threshold 0")
    left.set_title(
        f"Sensory commutativity probability\n{scp['n'].iloc[0]:,} experiments per degree of "
        "freedom\n95 % intervals"
    )
    baselines = tables["flatland_baselines"].set_index("dof").loc[DOF_ORDER]
    alternatives = tables["flatland_alternatives"].set_index("alternative")
    _draw_alternative(
        middle, baselines["naive_mse"], baselines["naive_se"], alternatives.loc["naive change"],
        "Naive alternative: change of the sensors", baselines["n_transitions"].iloc[0],
    )  # fmt: skip
    middle.set_ylabel("mean squared change of the view\n(squared 8-bit colour)")
    _draw_alternative(
        right, baselines["excess_error"], baselines["prediction_se"],
        alternatives.loc["excess prediction error"], "Prediction-error alternative, test set",
        baselines["n_test"].iloc[0],
    )  # fmt: skip
    right.set_ylabel("excess prediction error\n(squared 8-bit colour)")
    return figure


def _draw_alternative(
    axes: Axes,
    means: pd.Series,
    standard_errors: pd.Series,
    correlation: pd.Series,
    title: str,
    n: int,
) -> None:
    """Draw means with normal 95 % intervals; `correlation` is a row of flatland_alternatives."""
    values, half = means.to_numpy(), 1.96 * standard_errors.to_numpy()
    draw_dof_bars(axes, values, values - half, values + half)
    rho = "not defined"
    if not np.isnan(correlation["spearman"]):
        rho = f"{correlation['spearman']:+.2f} ({format_p_value(correlation['p'])})"
    axes.set_title(
        f"{title}\n{n:,} transitions per degree of freedom\nrank correlation with 1 − SCP: {rho}"
    )
