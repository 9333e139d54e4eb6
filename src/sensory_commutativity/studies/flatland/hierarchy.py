"""The paper's hierarchy of the degrees of freedom (section III-C), as pairs to compare, and what counts as found."""

from __future__ import annotations

from typing import NamedTuple

import pandas as pd

ALPHA = 0.001
"""Adjusted p-value below which a difference counts as found; fixed before the run."""

Pairs = tuple[tuple[str, str], ...]

HIERARCHY: dict[str, Pairs] = {
    "base below elbows": tuple(
        (b, e)
        for b in ("base-longitudinal", "base-rotation")
        for e in ("left-elbow", "right-elbow")
    ),
    "shoulders below elbows": tuple(
        (s, e) for s in ("left-shoulder", "right-shoulder") for e in ("left-elbow", "right-elbow")
    ),
    "elbows below head and eyelid": tuple(
        (e, still) for e in ("left-elbow", "right-elbow") for still in ("head", "eyelid")
    ),
}
"""Steps of the hierarchy -> pairs (lower SCP, higher SCP)."""

LEFT_AND_RIGHT: Pairs = (("left-shoulder", "right-shoulder"), ("left-elbow", "right-elbow"))
"""Pairs that should be equal."""


class Difference(NamedTuple):
    """SCP of one degree of freedom minus that of another, with its 95 % interval."""

    difference: float
    ci_low: float
    ci_high: float
    p_adjusted: float
    n: int


def ordered_difference(comparisons: pd.DataFrame, low: str, high: str) -> Difference:
    """SCP(low) - SCP(high) from the rows of flatland_comparisons of one agent in one world, whichever way round they hold the pair."""
    row = comparisons[
        comparisons["dof_a"].isin((low, high)) & comparisons["dof_b"].isin((low, high))
    ].iloc[0]
    if row["dof_a"] == low:
        ends = row["difference"], row["ci_low"], row["ci_high"]
    else:
        ends = -row["difference"], -row["ci_high"], -row["ci_low"]
    return Difference(*(float(end) for end in ends), float(row["p_adjusted"]), int(row["n"]))
