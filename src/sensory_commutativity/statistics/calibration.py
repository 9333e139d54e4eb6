"""Does the test keep its level on data like ours? A/A tests: two groups made from one, between which there is nothing to find."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .checks import fraction, sample


def split_rejections(values: ArrayLike, splits: int, alpha: float, rng: np.random.Generator) -> int:
    """How many of `splits` Welch tests between random halves of `values` (n,), n >= 4, have p < alpha.

    With odd n the second half has one run more. Halves that are constant and equal are not rejected; constant and different, they are, as in
    `groups.welch`.
    """
    values = sample(values, "values", least=4)
    fraction(alpha, "alpha")
    centred = values - values[0]  # equal values give exact zeros, and a variance of exactly 0
    shuffled = rng.permuted(np.tile(centred, (splits, 1)), axis=1)  # (splits, n)
    half = values.size // 2
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # constant halves
        p = stats.ttest_ind(shuffled[:, :half], shuffled[:, half:], axis=1, equal_var=False).pvalue
    return int((p < alpha).sum())  # NaN is not


def resampled_rejections(
    values: ArrayLike, draws: int, alpha: float, rng: np.random.Generator
) -> int:
    """How many of `draws` Welch tests have p < alpha, each between two groups of n drawn with replacement from `values` (n,), n >= 4.

    Both groups have the distribution of the values and the size that is compared in earnest; halves are smaller, and what one half has of rare
    values the other lacks, so that with skewed values they differ less often than alpha.
    """
    values = sample(values, "values", least=4)
    fraction(alpha, "alpha")
    centred = values - values[0]  # equal values give exact zeros, and a variance of exactly 0
    groups = centred[rng.integers(0, values.size, (2, draws, values.size))]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # constant groups
        p = stats.ttest_ind(groups[0], groups[1], axis=1, equal_var=False).pvalue
    return int((p < alpha).sum())  # NaN is not


def binomial_band(alpha: float, n: int, confidence: float = 0.95) -> tuple[float, float]:
    """Central interval of the share of rejections among `n` independent tests when each rejects with probability `alpha`; (low, high)."""
    fraction(alpha, "alpha"), fraction(confidence, "confidence")
    low, high = stats.binom.ppf([(1 - confidence) / 2, (1 + confidence) / 2], n, alpha) / n
    return float(low), float(high)
