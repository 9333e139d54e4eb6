"""Paired comparisons: McNemar's test, score intervals and equivalence tests of proportions,
Student's t of paired differences, Holm's correction."""

from __future__ import annotations

import math
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

    Tango 1998, https://doi.org/10.1002/(SICI)1097-0258(19980430)17:8<891::AID-SIM780>3.0.CO;2-B:
    the differences that a score test does not reject. It keeps its coverage also where few pairs
    are discordant, as with proportions near 0 and 1, where Wald's interval with half a pair added
    to each cell (Agresti and Min 2005) covers the difference too seldom.
    """
    from scipy.optimize import brentq  # takes half a second, and measure() needs mcnemar alone
    from scipy.stats import norm

    z = float(norm.ppf(0.5 + confidence / 2))
    estimate = (only_a - only_b) / n

    def end(sign: int) -> float:
        """The end of the interval above the estimate (sign 1) or below it (-1)."""

        def excess(distance: float) -> float:
            return abs(score_statistic(only_a, only_b, n, estimate + sign * distance)) - z

        most = 1 - sign * estimate
        if most <= 0 or excess(most) <= 0:
            return float(sign)
        return estimate + sign * brentq(excess, 0, most, xtol=1e-14, rtol=1e-12)

    return end(-1), end(1)


def score_statistic(only_a: int, only_b: int, n: int, difference: float) -> float:
    """Tango's score statistic of the hypothesis that a's proportion less b's is `difference`.

    Standard normal under the hypothesis; infinite if the data cannot occur under it.
    """
    distance = only_a - only_b - n * difference
    # the restricted maximum-likelihood estimate of the probability of "only b"
    square = 2 * n
    linear = -only_a - only_b + (2 * n - only_a + only_b) * difference
    constant = -only_b * difference * (1 - difference)
    root = math.sqrt(max(linear * linear - 4 * square * constant, 0.0))
    only_b_probability = (root - linear) / (2 * square)
    variance = n * (2 * only_b_probability + difference * (1 - difference))
    if variance <= 0:
        return 0.0 if distance == 0 else math.copysign(math.inf, distance)
    return distance / math.sqrt(variance)


def equivalence_test(only_a: int, only_b: int, n: int, margin: float) -> float:
    """p-value of two one-sided score tests that two paired proportions differ by `margin` or more.

    A small p shows that the difference lies within (-margin, margin). (Schuirmann 1987; with the
    score statistic of Tango 1998.) Raises ValueError unless the margin is in (0, 1).
    """
    from scipy.stats import norm

    if not 0 < margin < 1:
        raise ValueError(f"the margin must lie between 0 and 1; got {margin!r}")
    below = norm.sf(score_statistic(only_a, only_b, n, -margin))
    above = norm.cdf(score_statistic(only_a, only_b, n, margin))
    return float(max(below, above))


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
