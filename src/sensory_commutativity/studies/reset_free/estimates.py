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
QUIET = "return-quiet"
"""The return protocol at starts where nothing was seen to move beforehand."""
WATCHER = "eyelid"
"""The degree of freedom whose returns stand for waiting: it touches nothing, and its start is seen
again unless something moved by itself."""


def quiet_starts(trials: pd.DataFrame) -> pd.Index:
    """Starts of one world at which the view stayed the same for as long as a trial takes.

    Parameters
    ----------
    trials : DataFrame
        Columns dof, experiment, returned, waited. All degrees of freedom share their starts.
    """
    watched = trials[trials["dof"] == WATCHER].set_index("experiment")
    return watched.index[(watched["returned"] == 0) & (watched["waited"] == 0)]


def shares_starts(of_world: pd.DataFrame) -> bool:
    """Whether all degrees of freedom of a world were tried from the same starts."""
    return "life" in of_world and bool((of_world["life"] == of_world["experiment"]).all())


def at_quiet_starts(trials: pd.DataFrame) -> pd.DataFrame:
    """Trials from quiet starts, of the worlds whose degrees of freedom share their starts."""
    parts = []
    for _, of_world in trials.groupby("world", sort=False):
        if shares_starts(of_world) and WATCHER in set(of_world["dof"]):
            parts.append(of_world[of_world["experiment"].isin(quiet_starts(of_world))])
    return pd.concat(parts) if parts else trials[:0]


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
    chosen = [(trials, PROTOCOLS), (at_quiet_starts(trials), {QUIET: "distance"})]
    groups = [
        (world, dof, group, protocol, column)
        for part, protocols in chosen
        for (world, dof), group in part.groupby(["world", "dof"], sort=False)
        for protocol, column in protocols.items()
    ]
    for world, dof, group, protocol, column in groups:
        for threshold in thresholds:
            commuted = commutes(group[column].to_numpy(), threshold)
            low, high = wilson_interval(int(commuted.sum()), len(commuted))
            relative: tuple[float, float, float] = (np.nan, np.nan, np.nan)
            if protocol in ("return", QUIET):
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
