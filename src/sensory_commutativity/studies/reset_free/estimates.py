"""From trials of the return protocol to SCPs, relative to the control."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from ...scp.estimate import commutes

PROTOCOLS = {
    "reset": "reset",
    "return": "distance",
    "control": "control",
    "start-seen-again": "returned",
}
"""Protocol -> the column of its distances."""


def estimate_protocols(trials: pd.DataFrame, thresholds: Iterable[float]) -> pd.DataFrame:
    """The SCP of every degree of freedom by every protocol at every threshold.

    Parameters
    ----------
    trials : DataFrame
        Columns world, dof, and those of DISTANCES.
    thresholds : iterable of float

    Returns
    -------
    DataFrame
        world, dof, protocol, threshold, n, scp, ci_low, ci_high; and, for the return protocol,
        relative, relative_low, relative_high: the SCP over that of its control.
    """
    from ...statistics.proportions import wilson_interval
    from ...statistics.ratios import paired_ratio

    rows = []
    for (world, dof), group in trials.groupby(["world", "dof"], sort=False):
        for protocol, column in PROTOCOLS.items():
            for threshold in thresholds:
                commuted = commutes(group[column].to_numpy(), threshold)
                low, high = wilson_interval(int(commuted.sum()), len(commuted))
                relative: tuple[float, float, float] = (np.nan, np.nan, np.nan)
                if protocol == "return":
                    control = commutes(group["control"].to_numpy(), threshold)
                    relative = paired_ratio(commuted, control)
                rows.append(
                    (world, dof, protocol, float(threshold), len(commuted), commuted.mean(),
                     float(low), float(high), *relative)
                )  # fmt: skip
    return pd.DataFrame(
        rows,
        columns=["world", "dof", "protocol", "threshold", "n", "scp", "ci_low", "ci_high",
                 "relative", "relative_low", "relative_high"],
    )  # fmt: skip
