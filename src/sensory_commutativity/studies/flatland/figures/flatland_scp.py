"""SCP of every degree of freedom, and the two alternatives that the paper tried (paper, Fig. "SCP per degree of freedom")."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import DOF_ORDER, dof_bars, p_text, probability_axis, reference_rows


@figure(
    title="SCP of every degree of freedom, and the two alternatives that the paper tried",
    inputs=["flatland_scp", "flatland_baselines", "flatland_alternatives"],
    settings=lambda config: config.flatland,
)
def flatland_scp(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4.4))
    scp = reference_rows(tables["flatland_scp"], config)
    dof_bars(left, DOF_ORDER, scp["scp"], scp["ci_low"], scp["ci_high"], digits=3)
    probability_axis(left, "SCP at threshold 0")
    left.set_title(
        f"Sensory commutativity probability\n{scp['n'].iloc[0]:,} experiments per degree of freedom\n95 % intervals"
    )

    baselines = tables["flatland_baselines"].set_index("dof").loc[DOF_ORDER]
    alternatives = tables["flatland_alternatives"].set_index("alternative")
    for axes, column, spread, name, title, n in (
        (
            middle,
            "naive_mse",
            "naive_se",
            "naive change",
            "Naive alternative: change of the sensors",
            baselines["n_transitions"].iloc[0],
        ),
        (
            right,
            "excess_error",
            "prediction_se",
            "excess prediction error",
            "Prediction-error alternative, test set",
            baselines["n_test"].iloc[0],
        ),
    ):
        value, half = baselines[column].to_numpy(), 1.96 * baselines[spread].to_numpy()
        dof_bars(axes, DOF_ORDER, value, value - half, value + half)
        found = alternatives.loc[name]
        rho = (
            "not defined"
            if np.isnan(found["spearman"])
            else f"{found['spearman']:+.2f} ({p_text(found['p'])})"
        )
        axes.set_title(
            f"{title}\n{n:,} transitions per degree of freedom\nrank correlation with 1 − SCP: {rho}"
        )
    middle.set_ylabel("mean squared change of the view\n(squared 8-bit colour)")
    right.set_ylabel("excess prediction error\n(squared 8-bit colour)")
    return figure
