"""The SCP under noise, with threshold 0 and with a threshold that the control calibrates."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....storage.columns import FLOAT, INT, INTERVAL, TEXT, Column
from ...config import Config
from ...declarations import table
from ..builders import reset_free
from ..columns import DOF
from .reset_free_noise_experiments import NOISE

THRESHOLDS = ("0", "calibrated")


def calibrate(distance: np.ndarray, control: np.ndarray, quantile: float) -> np.ndarray:
    """Whether each experiment commuted, at a threshold from controls that it has no part in.

    The threshold of the experiments with even numbers is the quantile of the controls with odd
    numbers, and the other way round.

    Parameters
    ----------
    distance, control : float (n,), n >= 2
    quantile : float

    Returns
    -------
    bool (n,)
    """
    even = np.arange(len(distance)) % 2 == 0
    commuted = np.zeros(len(distance), bool)
    for half in (even, ~even):
        threshold = np.quantile(control[~half], quantile, method="higher")
        commuted[half] = distance[half] <= threshold
    return commuted


@table(
    title="SCP under noise",
    columns=(
        *NOISE,
        DOF,
        Column("threshold", TEXT, "", "0, or calibrated: a quantile of the control", key=True),
        Column("n", INT, "1", "experiments"),
        Column("scp", FLOAT, "1", "share of experiments that commuted"),
        *INTERVAL,
        Column("value", FLOAT, "squared 8-bit colour", "the threshold; of all controls"),
    ),
    inputs=["reset_free_noise_experiments"],
    settings=lambda config: reset_free(config).noise.quantile,
)
def reset_free_noise(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Of every degree of freedom, for every kind and level of noise."""
    from ....statistics.proportions import wilson_interval

    quantile, rows = reset_free(config).noise.quantile, []
    keys = ["noise", "protocol", "level", "dof"]
    for key, group in experiments.groupby(keys, sort=False):
        distance, control = group["distance"].to_numpy(), group["control"].to_numpy()
        calibrated = float(np.quantile(control, quantile, method="higher"))
        for threshold, value, commuted in (
            ("0", 0.0, distance <= 0),
            ("calibrated", calibrated, calibrate(distance, control, quantile)),
        ):
            low, high = wilson_interval(int(commuted.sum()), len(commuted))
            mean = float(commuted.mean())
            rows.append((*key, threshold, len(commuted), mean, float(low), float(high), value))
    return pd.DataFrame(rows, columns=reset_free_noise.column_names)
