"""Aggregates of one sample of runs with confidence intervals, and the ratio of two means.

Agarwal et al. 2021, "Deep reinforcement learning at the edge of the statistical precipice",
https://arxiv.org/abs/2108.13264, recommend interquartile means and bootstrap intervals.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .checks import check_fraction, check_sample


def interquartile_mean(x: ArrayLike, axis: int = 0) -> float | np.ndarray:
    """Mean of the middle half of the values (Agarwal et al. 2021).

    A quarter of the values, rounded down to a whole number of values, is dropped at either end.
    """
    return stats.trim_mean(x, 0.25, axis=axis)


def bootstrap_interval(
    x: ArrayLike,
    statistic: Callable,
    rng: np.random.Generator,
    resamples: int = 9_999,
    confidence: float = 0.95,
) -> tuple[float, float]:
    """Bias-corrected and accelerated (BCa) bootstrap interval of a statistic.

    Parameters
    ----------
    x : float (n,)
        One value per run.
    statistic : callable
        Array (n,) -> float. If it takes `axis`, like numpy's functions, all resamples are computed
        in one call.
    rng : Generator
    resamples : int
    confidence : float

    Returns
    -------
    low, high : float
        Where BCa is undefined, because leaving out any one run does not change the statistic, the
        percentile interval of the same resamples. If all values are equal, both ends are the
        statistic itself.
    """
    x = check_sample(x, "x")
    confidence = check_fraction(confidence, "confidence")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an undefined BCa interval: handled here
        bootstrap = stats.bootstrap(
            (x,), statistic, n_resamples=resamples, confidence_level=confidence,
            method="BCa", rng=rng,
        )  # fmt: skip
    low, high = bootstrap.confidence_interval
    if np.isnan(low) or np.isnan(high):
        low, high = percentile_interval(bootstrap.bootstrap_distribution, confidence)
    return float(low), float(high)


class Summary(NamedTuple):
    """Mean (t interval), median and interquartile mean (BCa bootstrap intervals) of n runs."""

    n: int
    mean: float
    mean_low: float
    mean_high: float
    median: float
    median_low: float
    median_high: float
    iqm: float
    iqm_low: float
    iqm_high: float


def summarize(
    x: ArrayLike, rng: np.random.Generator, resamples: int = 9_999, confidence: float = 0.95
) -> Summary:
    """Compute mean, median and interquartile mean of the runs x (n,) with their intervals.

    The intervals have zero width if all values are equal; see :func:`bootstrap_interval`.
    """
    x = check_sample(x, "x")
    confidence = check_fraction(confidence, "confidence")
    mean = float(x.mean())
    mean_low, mean_high = mean, mean
    if np.ptp(x):
        mean_low, mean_high = stats.t.interval(confidence, x.size - 1, mean, stats.sem(x))
    median_interval = bootstrap_interval(x, np.median, rng, resamples, confidence)
    iqm_interval = bootstrap_interval(x, interquartile_mean, rng, resamples, confidence)
    return Summary(
        x.size, mean, float(mean_low), float(mean_high), float(np.median(x)), *median_interval,
        float(interquartile_mean(x)), *iqm_interval,
    )  # fmt: skip


class Ratio(NamedTuple):
    """A ratio with its interval."""

    ratio: float
    ci_low: float
    ci_high: float


def ratio_of_means(
    a: ArrayLike,
    b: ArrayLike,
    rng: np.random.Generator,
    resamples: int = 9_999,
    confidence: float = 0.95,
) -> Ratio:
    """Ratio mean(a) / mean(b) of two independent samples, with a percentile bootstrap interval.

    Parameters
    ----------
    a, b : float (n,), (m,)
        One value per run. The samples are resampled independently.
    rng : Generator
    resamples : int
    confidence : float

    Returns
    -------
    Ratio
        The interval is (-inf, inf) where the mean of b does not differ from 0 at this confidence:
        where (1 - confidence) / 2 or more of its resampled means are 0 or have the other sign.
        Fieller's interval is unbounded then, too. Fewer such resamples are dropped.

    Raises
    ------
    ValueError
        If mean(b) is 0.
    """
    a, b = check_sample(a, "a"), check_sample(b, "b")
    confidence = check_fraction(confidence, "confidence")
    if b.mean() == 0:
        raise ValueError(
            "the ratio of means needs a second sample whose mean is not 0; "
            "compare the difference of means instead"
        )
    ratio = float(a.mean() / b.mean())
    means_a, means_b = (resampling_counts(x.size, resamples, rng) @ x / x.size for x in (a, b))
    usable = means_b * np.sign(b.mean()) > 0
    if 1 - usable.mean() >= (1 - confidence) / 2:
        return Ratio(ratio, -np.inf, np.inf)
    return Ratio(ratio, *percentile_interval(means_a[usable] / means_b[usable], confidence))


def resampling_counts(n: int, resamples: int, rng: np.random.Generator) -> np.ndarray:
    """Count how often each of n values is drawn in each bootstrap resample, int (resamples, n).

    ``counts @ x / n`` are the means of the resamples of x (n,).
    """
    return rng.multinomial(n, np.full(n, 1 / n), size=resamples)


def percentile_interval(resampled: np.ndarray, confidence: float) -> tuple[float, float]:
    """Central interval (low, high) that holds a fraction `confidence` of resampled values (n,)."""
    low, high = np.quantile(resampled, [(1 - confidence) / 2, (1 + confidence) / 2])
    return float(low), float(high)
