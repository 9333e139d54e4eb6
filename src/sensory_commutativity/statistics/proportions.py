"""Intervals of proportions."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

NORMAL_975 = 1.959963984540054
"""The 0.975 quantile of the standard normal distribution, correct to the last digit.
statistics.NormalDist, which gives the others, is off by one unit in the last place there."""


def wilson_interval(
    successes: ArrayLike, n: ArrayLike, confidence: float = 0.95
) -> tuple[np.ndarray, np.ndarray]:
    """Wilson's score interval of a proportion (Wilson 1927).

    It has good coverage even for proportions near 0 and 1: 10,000 of 10,000 gives [0.9996, 1].
    The formula is written out here because every table of SCPs needs it, and the package does
    without SciPy where it only measures.

    Parameters
    ----------
    successes, n : int or int arrays of equal shape
        Successes, and independent trials.
    confidence : float in (0, 1)

    Returns
    -------
    low, high : float arrays of the same shape, in [0, 1]
    """
    successes, n = np.asarray(successes), np.asarray(n)
    z = NORMAL_975 if confidence == 0.95 else -NormalDist().inv_cdf((1 - confidence) / 2)
    p = successes / n
    denominator = 1 + z**2 / n
    center = (p + z**2 / (2 * n)) / denominator
    half_width = z * np.sqrt(p * (1.0 - p) / n + z**2 / (4.0 * n**2)) / denominator
    low, high = np.clip(center - half_width, 0, 1), np.clip(center + half_width, 0, 1)
    # Exact ends where the formula leaves a rounding error of 1e-17.
    return np.where(successes == 0, 0.0, low), np.where(successes == n, 1.0, high)
