"""Comparisons of independent groups of runs: Welch's test, and others to cross-check it.

The unit is the run: one value per run, e.g. per training seed.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .aggregates import percentile_interval, resampling_counts
from .checks import check_fraction, check_sample


class Welch(NamedTuple):
    """Result of Welch's t-test of two groups, a and b."""

    statistic: float
    df: float  # Welch-Satterthwaite
    p: float  # two-sided
    difference: float  # mean of a minus mean of b
    ci_low: float
    ci_high: float
    effect_size: float  # Hedges' g


def welch(a: ArrayLike, b: ArrayLike, confidence: float = 0.95) -> Welch:
    """Welch's two-sided t-test of equal means, with an interval and an effect size.

    Parameters
    ----------
    a, b : float (n,), (m,)
        One value per run.
    confidence : float

    Returns
    -------
    Welch
        Hedges' g is the difference over the pooled standard deviation, times
        1 - 3 / (4 (n + m - 2) - 1). Two constant groups have no variance to test with. If they are
        equal, statistic and g are 0 and p is 1; if they differ, statistic and g are infinite with
        the sign of the difference, and p is 0. The interval is then the difference itself, and
        df = n + m - 2.
    """
    a, b = check_sample(a, "a"), check_sample(b, "b")
    confidence = check_fraction(confidence, "confidence")
    n, m = a.size, b.size
    if np.ptp(a) == np.ptp(b) == 0:
        d = float(a[0] - b[0])  # the difference of the means may have a rounding error
        signed = float(np.copysign(np.inf, d) if d else 0.0)
        return Welch(signed, float(n + m - 2), float(d == 0), d, d, d, signed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # "precision loss" if one group is constant
        test = stats.ttest_ind(a, b, equal_var=False)
    low, high = test.confidence_interval(confidence)
    difference = float(a.mean() - b.mean())
    pooled = np.sqrt(((n - 1) * a.var(ddof=1) + (m - 1) * b.var(ddof=1)) / (n + m - 2))
    g = difference / pooled * (1 - 3 / (4 * (n + m - 2) - 1))
    return Welch(
        float(test.statistic), float(test.df), float(test.pvalue),
        difference, float(low), float(high), float(g),
    )  # fmt: skip


class PairComparison(NamedTuple):
    """Difference of two means; p-value and interval hold for all pairs of a family at once."""

    difference: float
    p: float
    ci_low: float
    ci_high: float


def games_howell(
    groups: Mapping[str, ArrayLike], confidence: float = 0.95
) -> dict[tuple[str, str], PairComparison]:
    """Games-Howell test: all pairs of two or more groups with unequal variances and sizes.

    Parameters
    ----------
    groups : mapping of str to float (n,)
        Name -> one value per run.
    confidence : float

    Returns
    -------
    dict
        Pair of names (a, b), in the order of `groups` -> comparison of mean(a) - mean(b). The p of
        a pair of constant groups is 1 or 0, as in :func:`welch`.
    """
    values = {name: check_sample(x, f"group {name!r}") for name, x in groups.items()}
    if len(values) < 2:
        raise ValueError(f"a comparison of pairs needs at least two groups; got {list(values)}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # constant groups: 0 / 0, replaced below
        test = stats.tukey_hsd(*values.values(), equal_var=False)
        interval = test.confidence_interval(check_fraction(confidence, "confidence"))
    comparisons = {}
    for (i, (name_a, a)), (j, (name_b, b)) in combinations(enumerate(values.items()), 2):
        if np.ptp(a) == np.ptp(b) == 0:
            pair = welch(a, b)
            comparison = PairComparison(pair.difference, pair.p, pair.ci_low, pair.ci_high)
        else:
            matrices = (test.statistic, test.pvalue, interval.low, interval.high)
            comparison = PairComparison(*(float(matrix[i, j]) for matrix in matrices))
        comparisons[name_a, name_b] = comparison
    return comparisons


class RankTest(NamedTuple):
    """Result of a Mann-Whitney test."""

    statistic: float  # U of a: pairs in which a is larger; ties count one half
    p: float  # two-sided


def mann_whitney(a: ArrayLike, b: ArrayLike) -> RankTest:
    """Mann-Whitney test of two groups (n,), (m,).

    Exact if one group has at most 8 values and there are no ties, else the normal approximation.
    """
    test = stats.mannwhitneyu(check_sample(a, "a"), check_sample(b, "b"), alternative="two-sided")
    return RankTest(float(test.statistic), float(test.pvalue))


class Improvement(NamedTuple):
    """Probability that a run of a is larger than a run of b; ties count one half."""

    probability: float
    ci_low: float
    ci_high: float


def probability_of_improvement(
    a: ArrayLike,
    b: ArrayLike,
    rng: np.random.Generator,
    resamples: int = 9_999,
    confidence: float = 0.95,
) -> Improvement:
    """P(a > b) + P(a = b) / 2 = U / (n m) with a percentile bootstrap interval.

    Agarwal et al. 2021, https://arxiv.org/abs/2108.13264. The groups (n,), (m,) are resampled
    independently. Swap them if smaller is better. If the groups do not overlap, no resample does,
    and both ends of the interval are 0 or 1: it then does not measure the uncertainty;
    :func:`mann_whitney` does.
    """
    a, b = check_sample(a, "a"), check_sample(b, "b")
    confidence = check_fraction(confidence, "confidence")
    wins = (np.sign(a[:, None] - b) + 1) / 2  # (n, m): 1 where a is larger, 0.5 where equal
    counts_a, counts_b = (resampling_counts(x.size, resamples, rng) for x in (a, b))
    resampled = ((counts_a @ wins) * counts_b).sum(axis=1) / wins.size  # (resamples,)
    return Improvement(float(wins.mean()), *percentile_interval(resampled, confidence))


def permutation_test(
    a: ArrayLike, b: ArrayLike, rng: np.random.Generator, resamples: int = 9_999
) -> float:
    """Two-sided p of a permutation test of the difference of means of two groups (n,), (m,).

    It is twice the smaller tail, at most 1. All partitions of the runs are counted if there are at
    most `resamples`, otherwise `resamples` random ones and the observed one, so that p is at least
    2 / (resamples + 1).
    """

    def difference(x: np.ndarray, y: np.ndarray, axis: int) -> np.ndarray:
        return x.mean(axis=axis) - y.mean(axis=axis)

    samples = check_sample(a, "a"), check_sample(b, "b")
    test = stats.permutation_test(
        samples, difference, vectorized=True, n_resamples=resamples, rng=rng
    )
    return float(test.pvalue)
