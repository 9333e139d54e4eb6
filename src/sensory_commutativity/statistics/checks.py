"""What the comparisons of runs accept."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def sample(x: ArrayLike, name: str, least: int = 2) -> np.ndarray:
    """`x` as float array (n,) of one value per run; ValueError unless it has one axis, n >= `least`, and every value is finite."""
    x = np.asarray(x, float)
    if x.ndim != 1 or x.size < least:
        raise ValueError(
            f"{name} must be one value per run, in one dimension, of at least {least} runs; got shape {x.shape}"
        )
    if not np.isfinite(x).all():
        raise ValueError(
            f"{name} has {(~np.isfinite(x)).sum()} values that are not finite: give failed runs the score that the protocol sets for them"
        )
    return x


def fraction(value: float, name: str) -> float:
    """`value`; ValueError unless it lies strictly between 0 and 1."""
    if not 0 < value < 1:
        raise ValueError(f"{name} must lie between 0 and 1, e.g. 0.95 for 95 %; got {value}")
    return float(value)
