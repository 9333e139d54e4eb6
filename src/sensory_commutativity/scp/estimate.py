"""From distances to the Sensory Commutativity Probability (paper, section II-E)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ..errors import ArgumentError
from ..statistics.proportions import wilson_interval


def commutes(distance: np.ndarray, threshold: float = 0.0) -> np.ndarray:
    """Which experiments commuted, d(s_1, s_2) <= threshold: bool, the shape of `distance`.

    Raises ArgumentError if a distance is NaN, which says neither.
    """
    distance = np.asarray(distance)
    if np.isnan(distance).any():
        raise ArgumentError(
            f"distance: {int(np.isnan(distance).sum())} of {distance.size} are NaN; check the "
            "observations, and leave out experiments that failed"
        )
    return distance <= threshold


def estimate_scp(
    experiments: pd.DataFrame,
    by: Sequence[str],
    thresholds: Sequence[float],
    confidence: float = 0.95,
) -> pd.DataFrame:
    """Estimate the SCP of every group of experiments at every threshold.

    Parameters
    ----------
    experiments : DataFrame
        One row per SC-experiment, with a column ``distance`` and the columns `by`.
    by : sequence of str
        Columns that define a group, e.g. world, agent, dof. Groups keep the order in which they
        first appear.
    thresholds : sequence of float, >= 0
        Largest distances that count as equal.
    confidence : float in (0, 1)

    Returns
    -------
    DataFrame
        A row per group and threshold: `by`, threshold, n, commuted, scp, ci_low, ci_high (Wilson).

    Raises
    ------
    ArgumentError
        If `by` is a string or names a column that is missing, or if a distance is NaN.
    """
    if isinstance(by, str):
        raise ArgumentError(f"by: expected a list of column names, got {by!r}; write by=[{by!r}]")
    missing = [name for name in ("distance", *by) if name not in experiments]
    if missing or not by:
        raise ArgumentError(
            f"by: the experiments have no column {missing[0]!r}; they have "
            f"{', '.join(map(str, experiments.columns))}"
            if missing
            else "by: expected at least one column name, e.g. by=['dof']"
        )
    rows = []
    groups = experiments.groupby(list(by), sort=False, observed=True)["distance"]
    for group, distance in groups:
        for threshold in thresholds:
            commuted = int(commutes(distance.to_numpy(), threshold).sum())
            rows.append((*group, float(threshold), len(distance), commuted))
    table = pd.DataFrame(rows, columns=[*by, "threshold", "n", "commuted"])
    table["scp"] = table["commuted"] / table["n"]
    table["ci_low"], table["ci_high"] = wilson_interval(
        table["commuted"].to_numpy(), table["n"].to_numpy(), confidence
    )
    return table
