"""Ordering proportions that are measured on the same units, with as few units as needed.

Units come one after the other, and after any of them one may look and stop. Tests with this
property multiply capital: a fair game's capital exceeds 1 / alpha with probability alpha at most,
at whatever time one looks (Ville's inequality; Ramdas et al. 2023,
https://arxiv.org/abs/2210.01948).

Two questions are asked of every pair. *Which is lower?* If the proportions are equal, a discordant
unit is of either kind with probability one half; the capital is that of a bet on the other
probabilities, mixed uniformly. *Are they tied?* The difference is bounded by bets against at least
the margin, mixed over a few stakes (Waudby-Smith and Ramdas 2024,
https://arxiv.org/abs/2010.09686).

The level is divided by the number of pairs, and of a pair's share ORDER_SHARE is for its order: if
the proportions are equal, any order is wrong. If they differ, only one of the two is, which is at
most half as likely, and the rest is left for a tie that is none. Holm's correction would not be
valid here, since a pair that is said to be in an order may still be so in the wrong direction.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

LOWER, HIGHER, TIED, UNDECIDED = -1, 1, 2, 0
"""What is known of the first of a pair."""
STAKES = np.array([0.15, 0.4, 0.95])
"""Stakes of the bets against a difference, as a share of the largest. Chosen: the best stake is the
margin over the share of discordant units."""
ORDER_SHARE = 0.5
"""Share of a pair's level for its order; 1 - ORDER_SHARE / 2 is for a tie. Chosen."""


def log_capital_of_order(only_first: np.ndarray, only_second: np.ndarray) -> np.ndarray:
    """Logarithm of the capital against "first and second are equal".

    Parameters
    ----------
    only_first, only_second : int arrays of the same shape
        Units in which only the first, or only the second, was true.

    Returns
    -------
    float array
        Of ``2^n B(x + 1, y + 1)`` with n = x + y.
    """
    x, y = np.asarray(only_first), np.asarray(only_second)
    table = _log_factorials(int((x + y).max(initial=0)) + 1)
    return (x + y) * np.log(2) + table[x] + table[y] - table[x + y + 1]


def log_capital_of_tie(
    only_first: np.ndarray, only_second: np.ndarray, equal: np.ndarray, margin: float
) -> np.ndarray:
    """Logarithm of the capital against "they differ by `margin` or more": the smaller of the two
    against either sign of the difference.

    Parameters
    ----------
    only_first, only_second, equal : int arrays of the same shape
        Units in which only one, and in which both or none, were true.
    margin : float in (0, 1)
    """
    first, second = (
        _bet(only_first, only_second, equal, margin),
        _bet(only_second, only_first, equal, margin),
    )
    return np.minimum(first, second)


def _bet(higher: np.ndarray, lower: np.ndarray, equal: np.ndarray, margin: float) -> np.ndarray:
    """Log capital against a mean difference of at least `margin`, mixed over the stakes."""
    stakes = STAKES / (1 - margin)
    gains = np.log1p(-stakes * (1 - margin)), np.log1p(stakes * (1 + margin))
    total = (
        np.multiply.outer(higher, gains[0])
        + np.multiply.outer(lower, gains[1])
        + np.multiply.outer(equal, np.log1p(stakes * margin))
    )
    largest = total.max(axis=-1)
    return largest + np.log(np.exp(total - largest[..., None]).mean(axis=-1))


def _log_factorials(n: int) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, n + 1)))])


def pair_levels(alpha: float, pairs: int) -> tuple[float, float]:
    """Levels at which each pair is tested for its order, and for a tie."""
    return ORDER_SHARE * alpha / max(pairs, 1), (1 - ORDER_SHARE / 2) * alpha / max(pairs, 1)


class SequentialOrder:
    """Which of several proportions are lower, higher or tied, as units come in.

    The probability that anything said is wrong is at most `alpha`, whenever one looks and stops:
    that a pair is said to be in an order that it is not, or to be tied although the proportions
    differ by `margin` or more. An item whose pairs are all decided needs no further units.

    Parameters
    ----------
    items : int
        Number of proportions.
    alpha : float in (0, 1)
    margin : float in (0, 1)
        Smallest difference that is no tie.
    runs : int
        Independent runs side by side, for simulations.

    Attributes
    ----------
    pairs : list of (int, int)
    relations : int (runs, pairs)
        LOWER, HIGHER, TIED or UNDECIDED: what is known of the first of each pair.
    units : int (runs, items)
        Units that each item needed so far.
    """

    def __init__(self, items: int, alpha: float = 0.05, margin: float = 0.05, runs: int = 1):
        self.alpha, self.margin = alpha, margin
        self.pairs = list(combinations(range(items), 2))
        self._first, self._second = np.array(self.pairs, int).reshape(-1, 2).T
        self._levels = pair_levels(alpha, len(self.pairs))
        shape = (runs, len(self.pairs))
        self._only_first, self._only_second, self._equal = np.zeros((3, *shape), np.int64)
        self._order, self._tie = np.full((2, *shape), -np.inf)
        self._lead = np.zeros(shape, np.int8)  # the sign of the lead with the largest capital
        self.relations = np.zeros(shape, np.int8)
        self.units = np.zeros((runs, items), np.int64)

    @property
    def active(self) -> np.ndarray:
        """Items with a pair that is not decided: bool (runs, items)."""
        open_pairs = self.relations == UNDECIDED
        active = np.zeros(self.units.shape, bool)
        for k in range(active.shape[1]):
            mine = (self._first == k) | (self._second == k)
            active[:, k] = open_pairs[:, mine].any(axis=1)
        return active

    def update(self, outcomes: np.ndarray) -> None:
        """Take in further units, and look.

        Parameters
        ----------
        outcomes : bool (runs, units, items)
            Those of items that are not active are not read.
        """
        active = self.active
        both = active[:, self._first] & active[:, self._second]
        a, b = outcomes[..., self._first], outcomes[..., self._second]
        self._only_first += (a & ~b).sum(axis=1) * both
        self._only_second += (~a & b).sum(axis=1) * both
        self._equal += (a == b).sum(axis=1) * both
        self.units += outcomes.shape[1] * active
        self._look()

    def _look(self) -> None:
        x, y = self._only_first, self._only_second
        order = log_capital_of_order(x, y)
        self._lead = np.where(order > self._order, np.sign(x - y), self._lead)
        self._order = np.maximum(self._order, order)
        tie = log_capital_of_tie(x, y, self._equal, self.margin)
        self._tie = np.maximum(self._tie, tie)
        undecided = self.relations == UNDECIDED
        new = undecided & (self._order >= -np.log(self._levels[0]))
        self.relations[new] = self._lead[new]
        self.relations[undecided & ~new & (self._tie >= -np.log(self._levels[1]))] = TIED
