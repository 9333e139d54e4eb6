"""Intervals for proportions."""

from __future__ import annotations

import numpy as np
from statsmodels.stats.proportion import proportion_confint


def wilson_interval(successes: np.ndarray, n: np.ndarray, confidence: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
    """Wilson's score interval for `successes` of `n` independent trials; (low, high), each in [0, 1] and of the inputs' shape.

    It covers well near 0 and 1, where the SCP often is: 10,000 of 10,000 gives [0.9996, 1].
    """
    low, high = proportion_confint(np.asarray(successes), np.asarray(n), alpha=1 - confidence, method="wilson")
    return np.asarray(low), np.asarray(high)
