"""One group of runs in a few numbers: mean, median and interquartile mean with intervals, and the ratio of two groups' means."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .checks import fraction, sample


def interquartile_mean(x: ArrayLike, axis: int = 0) -> float | np.ndarray:
    """Mean of the middle half: a quarter of the values, rounded down to whole ones, is left out at either end (Agarwal et al. 2021)."""
    return stats.trim_mean(x, 0.25, axis=axis)


def bootstrap_interval(
    x: ArrayLike,
    statistic: Callable,
    rng: np.random.Generator,
    resamples: int = 9_999,
    confidence: float = 0.95,
) -> tuple[float, float]:
    """Bootstrap interval (BCa) of a statistic of the runs x.

    Parameters
    ----------
    x : float (n,)
        One value per run.
    statistic : callable
        Array (n,) -> float; if it takes `axis`, as numpy's functions do, all resamples are computed at once.

    Returns
    -------
    (low, high)
        Where BCa is undefined, as it is when leaving out any one run leaves the statistic as it is, the percentile interval of the same resamples;
        so, when all values are equal, the statistic itself twice.
    """
    x, confidence = sample(x, "x"), fraction(confidence, "confidence")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an undefined BCa interval: handled here
        found = stats.bootstrap(
            (x,),
            statistic,
            n_resamples=resamples,
            confidence_level=confidence,
            method="BCa",
            rng=rng,
        )
    low, high = found.confidence_interval
    if np.isnan(low) or np.isnan(high):
        low, high = percentile_interval(found.bootstrap_distribution, confidence)
    return float(low), float(high)


class Summary(NamedTuple):
    """Mean with its t interval, median and interquartile mean with BCa bootstrap intervals, of n runs."""

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


def summary(
    x: ArrayLike, rng: np.random.Generator, resamples: int = 9_999, confidence: float = 0.95
) -> Summary:
    """Summary of the runs x (n,), with intervals as `bootstrap_interval` gives them; of zero width when all values are equal."""
    x, confidence = sample(x, "x"), fraction(confidence, "confidence")
    mean = float(x.mean())
    mean_low, mean_high = (
        stats.t.interval(confidence, x.size - 1, mean, stats.sem(x)) if np.ptp(x) else (mean, mean)
    )
    return Summary(
        x.size,
        mean,
        float(mean_low),
        float(mean_high),
        float(np.median(x)),
        *bootstrap_interval(x, np.median, rng, resamples, confidence),
        float(interquartile_mean(x)),
        *bootstrap_interval(x, interquartile_mean, rng, resamples, confidence),
    )


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
    """mean(a) / mean(b) of two independent groups of runs, with a percentile bootstrap interval; the groups are resampled independently.

    The interval is (-inf, inf) when b's mean is not told apart from 0 at this confidence, i.e. when a share (1 - confidence) / 2 or more of its
    resampled means is 0 or has the other sign (Fieller's interval is unbounded then, too); a smaller share of them is left out. Raises ValueError
    when mean(b) is 0.
    """
    a, b, confidence = sample(a, "a"), sample(b, "b"), fraction(confidence, "confidence")
    if b.mean() == 0:
        raise ValueError(
            "the ratio of means needs a second group whose mean is not 0; compare the difference of means instead"
        )
    ratio = float(a.mean() / b.mean())
    means_a, means_b = (resampling_counts(x.size, resamples, rng) @ x / x.size for x in (a, b))
    usable = means_b * np.sign(b.mean()) > 0
    if 1 - usable.mean() >= (1 - confidence) / 2:
        return Ratio(ratio, -np.inf, np.inf)
    return Ratio(ratio, *percentile_interval(means_a[usable] / means_b[usable], confidence))


def resampling_counts(n: int, resamples: int, rng: np.random.Generator) -> np.ndarray:
    """How often each of n runs is in each bootstrap resample, int (resamples, n); `counts @ x / n` are resampled means of x."""
    return rng.multinomial(n, np.full(n, 1 / n), size=resamples)


def percentile_interval(resampled: np.ndarray, confidence: float) -> tuple[float, float]:
    """The central `confidence` of resampled values (resamples,)."""
    low, high = np.quantile(resampled, [(1 - confidence) / 2, (1 + confidence) / 2])
    return float(low), float(high)
