"""Checks of the arguments of the tests and intervals in this package."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def check_sample(x: ArrayLike, name: str, minimum: int = 2) -> np.ndarray:
    """Convert `x`, one value per run, to a float array (n,).

    Raises
    ------
    ValueError
        If `x` is not one-dimensional, has fewer than `minimum` values, or a value is not finite.
        The message calls it `name`.
    """
    x = np.asarray(x, float)
    if x.ndim != 1 or x.size < minimum:
        raise ValueError(
            f"{name} must have one dimension, with one value per run, and at least {minimum} runs; "
            f"got shape {x.shape}"
        )
    if not np.isfinite(x).all():
        raise ValueError(
            f"{name} has {(~np.isfinite(x)).sum()} values that are not finite; "
            "give failed runs the score that the protocol defines for them"
        )
    return x


def check_fraction(value: float, name: str) -> float:
    """Return `value`. Raises ValueError unless it lies strictly between 0 and 1."""
    if not 0 < value < 1:
        raise ValueError(f"{name} must lie between 0 and 1, e.g. 0.95 for 95 %; got {value}")
    return float(value)
