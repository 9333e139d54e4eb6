"""Two independent groups of runs compared: Welch's test first, others to see whether they agree. The unit is the run, i.e. the seed."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .aggregates import percentile_interval, resampling_counts
from .checks import fraction, sample


class Welch(NamedTuple):
    """Outcome of Welch's t-test of two groups, a and b."""

    statistic: float
    df: float  # Welch-Satterthwaite
    p: float  # two-sided
    difference: float  # mean of a minus mean of b
    ci_low: float
    ci_high: float
    effect_size: float  # Hedges' g


def welch(a: ArrayLike, b: ArrayLike, confidence: float = 0.95) -> Welch:
    """Welch's two-sided t-test of equal means, with the interval of the difference and Hedges' g.

    Parameters
    ----------
    a, b : float (n,), (m,)
        One value per run.

    Returns
    -------
    Welch
        Hedges' g is the difference over the pooled standard deviation times 1 - 3 / (4 (n + m - 2) - 1). Two groups that are each constant have no
        variance to test with: if they are equal, statistic and g are 0, p is 1; if they differ, statistic and g are infinite with the sign of the
        difference, p is 0. In both cases the interval is the difference itself and df = n + m - 2.
    """
    a, b, confidence = sample(a, "a"), sample(b, "b"), fraction(confidence, "confidence")
    n, m = a.size, b.size
    if np.ptp(a) == np.ptp(b) == 0:
        d = float(a[0] - b[0])  # the means can be off by a rounding error
        signed = np.copysign(np.inf, d) if d else 0.0
        return Welch(float(signed), float(n + m - 2), float(d == 0), d, d, d, float(signed))
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", RuntimeWarning
        )  # "precision loss" when one group is constant
        test = stats.ttest_ind(a, b, equal_var=False)
    low, high = test.confidence_interval(confidence)
    difference = float(a.mean() - b.mean())
    pooled = np.sqrt(((n - 1) * a.var(ddof=1) + (m - 1) * b.var(ddof=1)) / (n + m - 2))
    g = difference / pooled * (1 - 3 / (4 * (n + m - 2) - 1))
    return Welch(
        float(test.statistic),
        float(test.df),
        float(test.pvalue),
        difference,
        float(low),
        float(high),
        float(g),
    )


class Simultaneous(NamedTuple):
    """A difference of means with p-value and interval that hold for all pairs of a family at once."""

    difference: float
    p: float
    ci_low: float
    ci_high: float


def games_howell(
    groups: Mapping[str, ArrayLike], confidence: float = 0.95
) -> dict[tuple[str, str], Simultaneous]:
    """Games and Howell's comparison of all pairs of two or more groups, whose variances and sizes may differ.

    `groups` maps names to one value per run, float (n,). Keys of the result are pairs (a, b) in the order of `groups`, for mean(a) - mean(b). A
    pair of groups that are each constant has p 1 or 0 as in `welch`.
    """
    values = {name: sample(x, f"group {name!r}") for name, x in groups.items()}
    if len(values) < 2:
        raise ValueError(f"a comparison of pairs needs at least two groups; got {list(values)}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # constant groups: 0 / 0, replaced below
        test = stats.tukey_hsd(*values.values(), equal_var=False)
        interval = test.confidence_interval(fraction(confidence, "confidence"))
    found = {}
    for (i, (name_a, a)), (j, (name_b, b)) in combinations(enumerate(values.items()), 2):
        if np.ptp(a) == np.ptp(b) == 0:
            alone = welch(a, b)
            found[name_a, name_b] = Simultaneous(
                alone.difference, alone.p, alone.ci_low, alone.ci_high
            )
        else:
            found[name_a, name_b] = Simultaneous(
                *(
                    float(x[i, j])
                    for x in (test.statistic, test.pvalue, interval.low, interval.high)
                )
            )
    return found


class RankTest(NamedTuple):
    """Outcome of a Mann-Whitney test."""

    statistic: float  # U of a: pairs in which a is larger, ties half
    p: float  # two-sided


def mann_whitney(a: ArrayLike, b: ArrayLike) -> RankTest:
    """Mann-Whitney test of two groups (n,), (m,); exact when one has at most 8 values and there are no ties, else the normal approximation."""
    test = stats.mannwhitneyu(sample(a, "a"), sample(b, "b"), alternative="two-sided")
    return RankTest(float(test.statistic), float(test.pvalue))


class Improvement(NamedTuple):
    """Probability that a run of a is larger than a run of b, ties half."""

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
    """P(a > b) + P(a = b) / 2 = U / (n m) of two groups (n,), (m,), with a percentile bootstrap interval (Agarwal et al. 2021).

    The groups are resampled independently. Where smaller is better, swap them. When the groups do not overlap, no resample does, and the interval
    is 0 or 1 alone: it says nothing about how sure that is; `mann_whitney` does.
    """
    a, b, confidence = sample(a, "a"), sample(b, "b"), fraction(confidence, "confidence")
    wins = (np.sign(a[:, None] - b) + 1) / 2  # (n, m): 1 where a is larger, 0.5 where equal
    counts_a, counts_b = (resampling_counts(x.size, resamples, rng) for x in (a, b))
    resampled = ((counts_a @ wins) * counts_b).sum(axis=1) / wins.size
    return Improvement(float(wins.mean()), *percentile_interval(resampled, confidence))


def permutation(
    a: ArrayLike, b: ArrayLike, rng: np.random.Generator, resamples: int = 9_999
) -> float:
    """Two-sided p of a permutation test of the difference of means of two groups (n,), (m,).

    Twice the smaller tail, at most 1. All ways to divide the runs are counted where there are at most `resamples`; otherwise that many random ones
    and the one observed, so that p is never below 2 / (resamples + 1).
    """

    def difference(x: np.ndarray, y: np.ndarray, axis: int) -> np.ndarray:
        return x.mean(axis=axis) - y.mean(axis=axis)

    test = stats.permutation_test(
        (sample(a, "a"), sample(b, "b")),
        difference,
        vectorized=True,
        n_resamples=resamples,
        rng=rng,
    )
    return float(test.pvalue)
