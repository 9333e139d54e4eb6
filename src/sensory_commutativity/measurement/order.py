"""The order of the degrees of freedom by their SCP, and how certain it is."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from ..scp.estimate import commutes
from ..statistics.paired import holm, mcnemar
from ..statistics.proportions import wilson_interval

MAX_TIES = 6
"""Pairs that the text names; chosen: two lines."""


@dataclass(frozen=True, eq=False)
class DofOrder:
    """Degrees of freedom from lowest to highest SCP.

    All degrees of freedom are tried from the same starts, so that two of them are compared by
    McNemar's test; Holm's correction bounds the probability of any error among all pairs.

    Attributes
    ----------
    threshold, alpha : float
        Largest distance that counts as equal, and level of the tests.
    table : DataFrame
        One row per degree of freedom, lowest first: rank, dof, n, scp, ci_low, ci_high (95 %,
        Wilson).
    pairs : DataFrame
        One row per pair, `lower` before `higher` in the order: lower, higher, difference (of
        their SCPs), only_lower and only_higher (starts from which only that one commuted), p,
        p_adjusted (Holm), distinct (p_adjusted <= alpha).
    """

    threshold: float
    alpha: float
    table: pd.DataFrame
    pairs: pd.DataFrame

    @property
    def dofs(self) -> tuple[str, ...]:
        """Names, from lowest to highest SCP."""
        return tuple(self.table["dof"])

    @property
    def ties(self) -> list[tuple[str, str]]:
        """Pairs without a significant difference."""
        tied = self.pairs[~self.pairs["distinct"]]
        return list(zip(tied["lower"], tied["higher"], strict=True))

    def __str__(self) -> str:
        n = int(self.table["n"].iloc[0])
        lines = [f"lowest to highest SCP, threshold {self.threshold:g}, n = {n:,}"]
        width = max(map(len, self.dofs))
        for row in self.table.itertuples():
            interval = f"[{row.ci_low:.3f}, {row.ci_high:.3f}]"
            lines.append(f"{row.rank:3}  {row.dof:{width}}  {row.scp:.3f}  {interval}")
        if not len(self.pairs):
            return "\n".join(lines)
        distinct = int(self.pairs["distinct"].sum())
        lines.append(
            f"{distinct} of {len(self.pairs)} pairs differ significantly "
            f"(McNemar's test, Holm's correction, level {self.alpha:g})"
        )
        if self.ties and distinct:
            shown = [f"{a} and {b}" for a, b in self.ties[:MAX_TIES]]
            more = len(self.ties) - len(shown)
            shown += [f"and {more} more (see .pairs)"] if more else []
            lines.append("not: " + "; ".join(shown))
        return "\n".join(lines)

    __repr__ = __str__


def order_dofs(
    distances: np.ndarray, names: tuple[str, ...], threshold: float, alpha: float
) -> DofOrder:
    """Order degrees of freedom by their SCP.

    Parameters
    ----------
    distances : float (n, n_dofs)
        Row i holds the experiments from start i.
    names : tuple of str
        One per column.
    threshold : float
    alpha : float in (0, 1)
    """
    commuted = commutes(distances, threshold)
    n, counts = len(commuted), commuted.sum(axis=0)
    order = np.argsort(counts, kind="stable")
    low, high = wilson_interval(counts[order], np.full(len(order), n))
    table = pd.DataFrame(
        dict(
            rank=np.arange(1, len(order) + 1),
            dof=[names[k] for k in order],
            n=n,
            scp=counts[order] / n,
            ci_low=low,
            ci_high=high,
        )
    )
    rows = []
    for a, b in combinations(order, 2):
        test = mcnemar(commuted[:, a], commuted[:, b])
        rows.append((names[a], names[b], -test.difference, test.only_a, test.only_b, test.p))
    columns = ["lower", "higher", "difference", "only_lower", "only_higher", "p"]
    pairs = pd.DataFrame(rows, columns=columns)
    pairs["p_adjusted"] = holm(pairs["p"].to_numpy()) if rows else pairs["p"]
    pairs["distinct"] = pairs["p_adjusted"] <= alpha
    return DofOrder(threshold, alpha, table, pairs)
