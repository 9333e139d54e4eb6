"""The paper's hierarchy of the degrees of freedom in Flatland (section III-C), as pairs to
compare."""

from __future__ import annotations

from typing import NamedTuple

import pandas as pd

ALPHA = 0.001
"""Adjusted p-value below which a difference counts as found; fixed before the run."""

Pairs = tuple[tuple[str, str], ...]

BASE = ("base-longitudinal", "base-rotation")
SHOULDERS = ("left-shoulder", "right-shoulder")
ELBOWS = ("left-elbow", "right-elbow")
STILL = ("head", "eyelid")

HIERARCHY: dict[str, Pairs] = {
    "base below elbows": tuple((low, high) for low in BASE for high in ELBOWS),
    "shoulders below elbows": tuple((low, high) for low in SHOULDERS for high in ELBOWS),
    "elbows below head and eyelid": tuple((low, high) for low in ELBOWS for high in STILL),
}
"""Steps of the hierarchy -> pairs (lower SCP, higher SCP)."""

LEFT_AND_RIGHT: Pairs = (SHOULDERS, ELBOWS)
"""Pairs that should be equal."""


class Difference(NamedTuple):
    """SCP of one degree of freedom minus that of another, with its 95 % interval.

    `only_low` and `only_high` are the starts from which only one of them commuted.
    """

    difference: float
    ci_low: float
    ci_high: float
    p_adjusted: float
    n: int
    only_low: int
    only_high: int

    def equivalence_p(self, margin: float) -> float:
        """p-value that the difference is `margin` or more; see :func:`.paired.equivalence_test`."""
        from ...statistics.paired import equivalence_test

        return equivalence_test(self.only_low, self.only_high, self.n, margin)


def find_difference(comparisons: pd.DataFrame, low: str, high: str) -> Difference:
    """SCP(low) - SCP(high), whichever way round the table holds the pair.

    `comparisons` are the rows of flatland_comparisons of one agent in one world.
    """
    pair = (low, high)
    row = comparisons[comparisons["dof_a"].isin(pair) & comparisons["dof_b"].isin(pair)].iloc[0]
    if row["dof_a"] == low:
        ends = row["difference"], row["ci_low"], row["ci_high"]
        only = int(row["only_a"]), int(row["only_b"])
    else:
        ends = -row["difference"], -row["ci_high"], -row["ci_low"]
        only = int(row["only_b"]), int(row["only_a"])
    difference, low_end, high_end = (float(end) for end in ends)
    return Difference(difference, low_end, high_end, float(row["p_adjusted"]), int(row["n"]), *only)
