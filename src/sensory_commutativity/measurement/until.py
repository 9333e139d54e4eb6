"""Measuring until the order of the degrees of freedom is decided."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from ..errors import ArgumentError
from ..scp.estimate import commutes
from ..statistics.proportions import wilson_interval
from ..statistics.sequential import HIGHER, TIED, UNDECIDED, SequentialOrder
from .order import MAX_TIES, DofOrder

ORDERED = "ordered"
"""Name of the rule."""
LOOK = 10
"""Starts between two looks at the results. Chosen: few looks are cheap, and little is lost."""


@dataclass(frozen=True)
class Stopping:
    """When to stop, fixed before the first experiment.

    Attributes
    ----------
    alpha : float
        Largest probability that anything said of the order is wrong.
    margin : float
        SCPs that differ by less may be called tied.
    threshold : float
        Largest distance that counts as equal.
    """

    alpha: float
    margin: float
    threshold: float


def check_stopping(
    until: str | None, alpha: float, margin: float, threshold: float
) -> Stopping | None:
    """Check these arguments; None without a rule. Raises ArgumentError."""
    if until is None:
        return None
    if until != ORDERED:
        raise ArgumentError(f"until: expected {ORDERED!r} or None, got {until!r}")
    for name, value in (("alpha", alpha), ("margin", margin)):
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1:
            raise ArgumentError(f"{name}: expected a number between 0 and 1, got {value!r}")
    return Stopping(float(alpha), float(margin), float(threshold))


def replay(distances: np.ndarray, stopping: Stopping) -> SequentialOrder:
    """What was decided by the starts in `distances`, float (n, n_dofs); NaN where not played."""
    played = ~np.isnan(distances)
    commuted = commutes(np.where(played, distances, 0.0), stopping.threshold)
    test = SequentialOrder(distances.shape[1], stopping.alpha, stopping.margin)
    for start in range(0, len(distances), LOOK):
        test.update(commuted[None, start : start + LOOK])
    return test


@dataclass(frozen=True, eq=False)
class SequentialDofOrder(DofOrder):
    """The order of degrees of freedom that were measured until it was decided.

    The columns of `table` are those of :class:`.DofOrder`, where n differs between rows. `pairs`
    has lower, higher, difference, only_lower, only_higher, n (starts in which both were tried),
    distinct and tied; a pair that is neither is not decided.
    """

    margin: float

    @property
    def undecided(self) -> list[tuple[str, str]]:
        """Pairs that are neither ordered nor found tied."""
        return _names(self.pairs[~self.pairs["distinct"] & ~self.pairs["tied"]])

    @property
    def ties(self) -> list[tuple[str, str]]:
        """Pairs that were found to differ by less than the margin."""
        return _names(self.pairs[self.pairs["tied"]])

    def __str__(self) -> str:
        lines = [f"lowest to highest SCP, threshold {self.threshold:g}, until ordered"]
        width = max(map(len, self.dofs))
        for row in self.table.itertuples():
            interval = f"[{row.ci_low:.3f}, {row.ci_high:.3f}]"
            lines.append(
                f"{row.rank:3}  {row.dof:{width}}  {row.scp:.3f}  {interval}  n = {row.n:,}"
            )
        if not len(self.pairs):
            return "\n".join(lines)
        lines.append(
            f"{int(self.pairs['distinct'].sum())} of {len(self.pairs)} pairs are ordered, "
            f"{len(self.ties)} tied (differ by less than {self.margin:g}), {len(self.undecided)} "
            f"not decided; anything of this is wrong with probability {self.alpha:g} at most"
        )
        for word, found in (("tied", self.ties), ("not decided", self.undecided)):
            if found:
                shown = [f"{a} and {b}" for a, b in found[:MAX_TIES]]
                more = len(found) - len(shown)
                shown += [f"and {more} more (see .pairs)"] if more else []
                lines.append(f"{word}: " + "; ".join(shown))
        return "\n".join(lines)

    __repr__ = __str__


def _names(pairs: pd.DataFrame) -> list[tuple[str, str]]:
    return list(zip(pairs["lower"], pairs["higher"], strict=True))


def order_sequentially(
    distances: np.ndarray, names: tuple[str, ...], stopping: Stopping
) -> SequentialDofOrder:
    """The order that was decided.

    Parameters
    ----------
    distances : float (n, n_dofs)
        Row i holds the experiments from start i; NaN where none was needed.
    names : tuple of str
    stopping : Stopping
    """
    test = replay(distances, stopping)
    played = ~np.isnan(distances)
    commuted = played & (np.nan_to_num(distances) <= stopping.threshold)
    n, counts = played.sum(axis=0), commuted.sum(axis=0)
    scp = counts / n
    order = np.argsort(scp, kind="stable")
    low, high = wilson_interval(counts[order], n[order])
    table = pd.DataFrame(
        dict(
            rank=np.arange(1, len(order) + 1), dof=[names[k] for k in order], n=n[order],
            scp=scp[order], ci_low=low, ci_high=high,
        )
    )  # fmt: skip
    rows = []
    for (i, j), relation in zip(test.pairs, test.relations[0], strict=True):
        # What was decided ranks before what the estimates say.
        first_is_lower = scp[i] <= scp[j] if relation in (TIED, UNDECIDED) else relation != HIGHER
        low_one, high_one = (i, j) if first_is_lower else (j, i)
        both = played[:, i] & played[:, j]
        a, b = commuted[both, low_one], commuted[both, high_one]
        rows.append(
            (names[low_one], names[high_one], float(b.mean() - a.mean()), int((a & ~b).sum()),
             int((b & ~a).sum()), int(both.sum()), relation not in (TIED, UNDECIDED),
             relation == TIED)
        )  # fmt: skip
    columns = ["lower", "higher", "difference", "only_lower", "only_higher", "n", "distinct",
               "tied"]  # fmt: skip
    pairs = pd.DataFrame(rows, columns=columns).astype({"distinct": bool, "tied": bool})
    return SequentialDofOrder(stopping.threshold, stopping.alpha, table, pairs, stopping.margin)
