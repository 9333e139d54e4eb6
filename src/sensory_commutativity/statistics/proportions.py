"""Intervals of proportions."""

from __future__ import annotations

import numpy as np
from statsmodels.stats.proportion import proportion_confint


def wilson_interval(
    successes: np.ndarray, n: np.ndarray, confidence: float = 0.95
) -> tuple[np.ndarray, np.ndarray]:
    """Wilson's score interval of a proportion.

    It has good coverage even for proportions near 0 and 1: 10,000 of 10,000 gives [0.9996, 1].

    Parameters
    ----------
    successes, n : int arrays of equal shape
        Successes, and independent trials.
    confidence : float

    Returns
    -------
    low, high : float arrays of the same shape, in [0, 1]
    """
    successes, n = np.asarray(successes), np.asarray(n)
    low, high = proportion_confint(successes, n, alpha=1 - confidence, method="wilson")
    # Exact ends where the formula leaves a rounding error of 1e-17.
    return np.where(successes == 0, 0.0, low), np.where(successes == n, 1.0, high)
