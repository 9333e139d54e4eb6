"""A/A tests: does Welch's test keep its level on data with this distribution?

Two groups are made from the same values, so that every rejection is a false one.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .checks import check_fraction, check_sample


def count_split_rejections(
    values: ArrayLike, splits: int, alpha: float, rng: np.random.Generator
) -> int:
    """Count Welch tests with p < alpha between random halves of `values` (n,), n >= 4.

    Of `splits` tests. With odd n the second half has one run more. Two constant halves are
    rejected if they differ, as in :func:`.groups.welch`.
    """
    values = check_sample(values, "values", minimum=4)
    check_fraction(alpha, "alpha")
    centred = values - values[0]  # equal values give exact zeros, and a variance of exactly 0
    shuffled = rng.permuted(np.tile(centred, (splits, 1)), axis=1)  # (splits, n)
    half = values.size // 2
    return _count_rejections(shuffled[:, :half], shuffled[:, half:], alpha)


def count_resampled_rejections(
    values: ArrayLike, draws: int, alpha: float, rng: np.random.Generator
) -> int:
    """Count Welch tests with p < alpha between two groups drawn with replacement.

    Of `draws` tests. Each group has n values drawn from `values` (n,), n >= 4. Unlike halves, the
    groups have the size of the real comparison and are independent. Of two halves, one lacks the
    rare values that the other has, so that with skewed values they reject less often than alpha.
    """
    values = check_sample(values, "values", minimum=4)
    check_fraction(alpha, "alpha")
    centred = values - values[0]  # equal values give exact zeros, and a variance of exactly 0
    groups = centred[rng.integers(0, values.size, (2, draws, values.size))]
    return _count_rejections(groups[0], groups[1], alpha)


def _count_rejections(a: np.ndarray, b: np.ndarray, alpha: float) -> int:
    """Rows in which Welch's test of a (tests, n) and b (tests, m) has p < alpha."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # constant groups
        p = stats.ttest_ind(a, b, axis=1, equal_var=False).pvalue
    return int((p < alpha).sum())  # p is NaN, and not counted, where both are constant and equal


def binomial_band(alpha: float, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Central interval (low, high) of the fraction of rejections.

    Of `n` independent tests, each of which rejects with probability `alpha`.
    """
    check_fraction(alpha, "alpha")
    check_fraction(confidence, "confidence")
    low, high = stats.binom.ppf([(1 - confidence) / 2, (1 + confidence) / 2], n, alpha) / n
    return float(low), float(high)
