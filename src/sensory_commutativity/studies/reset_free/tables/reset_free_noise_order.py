"""How far the order of the degrees of freedom survives noise, and how many experiments it needs."""

from __future__ import annotations

from itertools import chain

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, INT, INTERVAL, TEXT, Column
from ...config import Config
from ...declarations import table
from ...flatland.hierarchy import HIERARCHY
from ..builders import reset_free
from .reset_free_noise import THRESHOLDS, calibrate
from .reset_free_noise_experiments import NOISE

POWER = 0.9
"""Share of repetitions in which the number of experiments that is reported suffices. Chosen."""
LEVEL = 0.05


def decide(experiments: pd.DataFrame, threshold: str, quantile: float) -> pd.DataFrame:
    """Which experiments commuted: bool, a row per experiment, a column per degree of freedom."""
    columns = {}
    for dof, group in experiments.groupby("dof", sort=False):
        group = group.sort_values("experiment")
        distance, control = group["distance"].to_numpy(), group["control"].to_numpy()
        columns[dof] = distance <= 0 if threshold == "0" else calibrate(distance, control, quantile)
    return pd.DataFrame(columns)


def experiments_needed(commuted: pd.DataFrame) -> float:
    """Experiments with which every step of the hierarchy is found with power POWER.

    By the normal approximation of McNemar's test at LEVEL, with Bonferroni's correction; infinite
    if a step has the wrong sign.
    """
    from scipy import stats

    steps = list(chain.from_iterable(HIERARCHY.values()))
    z_level = float(stats.norm.isf(LEVEL / len(steps) / 2))
    z_power = float(stats.norm.ppf(POWER))
    needed = 0.0
    for lower, higher in steps:
        a, b = commuted[lower], commuted[higher]
        discordant, difference = float((a != b).mean()), float(b.mean() - a.mean())
        if difference <= 0:
            return float("inf")
        root = z_level * discordant**0.5 + z_power * max(discordant - difference**2, 0.0) ** 0.5
        needed = max(needed, (root / difference) ** 2)
    return float(np.ceil(needed))


@table(
    title="The order of the degrees of freedom under noise",
    columns=(
        *NOISE,
        Column("threshold", TEXT, "", "0 or calibrated", key=True),
        Column("n", INT, "1", "experiments of each degree of freedom"),
        Column(
            "tau", FLOAT, "1", "Kendall's tau of the SCPs with those without noise", nullable=True
        ),
        *INTERVAL,
        Column("steps", INT, "1", "pairs of the paper's hierarchy"),
        Column("steps_found", INT, "1", "how many of them differ as they should, p < .01 (Holm)"),
        Column(
            "needed", FLOAT, "1",
            "experiments with which all are found with a power of .9; infinite if one has the "
            "wrong sign",
        ),
    ),
    inputs=["reset_free_noise_experiments"],
    settings=lambda config: reset_free(config).noise.quantile,
)  # fmt: skip
def reset_free_noise_order(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """For every kind and level of noise, with both thresholds."""
    from ....statistics.orders import order_agreement
    from ....statistics.paired import holm, mcnemar

    quantile, rows = reset_free(config).noise.quantile, []
    steps = list(chain.from_iterable(HIERARCHY.values()))
    for (noise, protocol), of_kind in experiments.groupby(["noise", "protocol"], sort=False):
        clean = decide(of_kind[of_kind["level"] == 0], "0", quantile)
        for level, group in of_kind.groupby("level", sort=False):
            for threshold in THRESHOLDS:
                commuted = decide(group, threshold, quantile)
                rng = generator(config.seed, "noise order", str(noise), str(protocol), threshold)
                tau = order_agreement(clean.to_numpy(), commuted.to_numpy(), rng, paired=True)
                tests = [mcnemar(commuted[low], commuted[high]) for low, high in steps]
                adjusted = holm(np.array([test.p for test in tests]))
                found = [
                    p < 0.01 and test.difference < 0
                    for p, test in zip(adjusted, tests, strict=True)
                ]
                rows.append(
                    (noise, protocol, level, threshold, len(commuted), *tau, len(steps),
                     sum(found), experiments_needed(commuted))
                )  # fmt: skip
    return pd.DataFrame(rows, columns=reset_free_noise_order.column_names)
