"""Paired comparisons: McNemar's test, Student's t of paired differences, Holm's correction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class McNemar(NamedTuple):
    """Result of a McNemar test of two paired yes/no measurements, a and b."""

    only_a: int  # pairs with a and not b
    only_b: int
    difference: float  # proportion of a minus proportion of b
    p: float  # exact, two-sided


def mcnemar(a: np.ndarray, b: np.ndarray) -> McNemar:
    """Exact two-sided McNemar test of two boolean arrays (n,) measured on the same n units.

    If the proportions are equal, a discordant pair is of either kind with probability one half.
    Raises ValueError if the arrays differ in shape or are empty.
    """
    a, b = np.asarray(a, bool), np.asarray(b, bool)
    if a.shape != b.shape or a.size == 0:
        raise ValueError(
            "a paired test needs two arrays of equal, non-zero length; "
            f"got shapes {a.shape} and {b.shape}"
        )
    only_a, only_b = int((a & ~b).sum()), int((b & ~a).sum())
    discordant = only_a + only_b
    p = sign_test(only_a, discordant)
    return McNemar(only_a, only_b, (only_a - only_b) / a.size, p)


def sign_test(successes: int, n: int) -> float:
    """Exact two-sided p-value of `successes` in `n` trials of probability one half.

    Binomial coefficients are summed as whole numbers; the only rounding is that of the result.
    """
    fewer = min(successes, n - successes)
    if 2 * fewer == n:
        return 1.0
    term = total = 1  # n over 0
    for k in range(fewer):
        term = term * (n - k) // (k + 1)
        total += term
    return 2 * total / 2**n


def paired_difference_interval(
    only_a: int, only_b: int, n: int, confidence: float = 0.95
) -> tuple[float, float]:
    """Interval (low, high) of the difference of two proportions measured on the same n units.

    Agresti and Min 2005, https://doi.org/10.1002/sim.1781: Wald's interval after half a pair is
    added to each of the four cells.
    """
    from scipy import stats  # takes half a second, and measure() needs mcnemar alone

    z = float(stats.norm.ppf(0.5 + confidence / 2))
    a, b, total = only_a + 0.5, only_b + 0.5, n + 2
    difference = (a - b) / total
    half = z * np.sqrt(a + b - (a - b) ** 2 / total) / total
    return max(-1.0, difference - half), min(1.0, difference + half)


def paired_means(difference: np.ndarray, confidence: float = 0.95) -> tuple[float, float, float]:
    """Student's t-test that the mean of paired differences is 0.

    Parameters
    ----------
    difference : float (n,)
    confidence : float

    Returns
    -------
    low, high : float
        Interval of the mean.
    p : float
        Two-sided. If all differences are equal there is no variance to test with: p is that of the
        exact sign test, and the interval reaches from their value to the mean that results if as
        many of them had the other sign as the Clopper-Pearson interval of 0 in n allows. If all
        are 0, the interval is [0, 0] and p is 1.
    """
    from scipy import stats

    mean, n = float(difference.mean()), len(difference)
    if np.ptp(difference) == 0:
        if mean == 0:
            return 0.0, 0.0, 1.0
        ends = sorted((mean, mean * (1 - 2 * (1 - ((1 - confidence) / 2) ** (1 / n)))))
        return ends[0], ends[1], min(1.0, 2.0 ** (1 - n))
    low, high = stats.t.interval(confidence, len(difference) - 1, mean, stats.sem(difference))
    return float(low), float(high), float(stats.ttest_1samp(difference, 0).pvalue)


def holm(p: np.ndarray) -> np.ndarray:
    """Adjust the p-values of a family of tests by Holm's step-down method (Holm 1979).

    Same shape (n,); each is at most 1.
    """
    p = np.asarray(p, float)
    order = np.argsort(p)
    adjusted = np.empty_like(p)
    adjusted[order] = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    return np.minimum(adjusted, 1)
