"""Intervals for proportions."""

from __future__ import annotations

import numpy as np
from statsmodels.stats.proportion import proportion_confint


def wilson_interval(
    successes: np.ndarray, n: np.ndarray, confidence: float = 0.95
) -> tuple[np.ndarray, np.ndarray]:
    """Wilson's score interval for `successes` of `n` independent trials; (low, high), each in [0, 1] and of the inputs' shape.

    It covers well near 0 and 1, where the SCP often is: 10,000 of 10,000 gives [0.9996, 1].
    """
    successes, n = np.asarray(successes), np.asarray(n)
    low, high = proportion_confint(successes, n, alpha=1 - confidence, method="wilson")
    return np.where(successes == 0, 0.0, low), np.where(
        successes == n, 1.0, high
    )  # exact where rounding would leave 1e-17
