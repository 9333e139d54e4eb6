"""Distances between two observations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import ArgumentError

Distance = Callable[[np.ndarray, np.ndarray], float]
"""d(s_1, s_2) >= 0 for two observations of the same shape; 0 for equal ones."""


def mean_squared_error(first: np.ndarray, second: np.ndarray) -> float:
    """Mean of the squared differences of all elements (paper, section III-A).

    Parameters
    ----------
    first, second : array
        Observations of the same shape, of any number type.

    Returns
    -------
    float
        For 8-bit colours in [0, 255**2].

    Raises
    ------
    ArgumentError
        If the shapes differ, or if an observation is not an array of numbers.
    """
    for observation in (first, second):
        if not isinstance(observation, np.ndarray) or observation.dtype.kind not in "biuf":
            kind = getattr(observation, "dtype", type(observation).__name__)
            raise ArgumentError(
                f"observation: expected an array of numbers, got {kind}; let observe() return one "
                "array, or give a distance of your own"
            )
    if first.shape != second.shape:
        raise ArgumentError(
            f"observation: two of different shapes cannot be compared, {first.shape} and "
            f"{second.shape}; let observe() return arrays of one shape"
        )
    difference = first.astype(np.float64) - second.astype(np.float64)
    return float(np.mean(difference * difference))


def scaled_difference(first: np.ndarray, second: np.ndarray, unit: np.ndarray) -> float:
    """Root mean square of the differences, each in units of its sensor.

    Sensors that never move do not count, unless the two observations differ in them: then they do,
    in the median unit of the others.

    Parameters
    ----------
    first, second : float (n,)
    unit : float (n,)
        Infinite for a sensor that never moves.
    """
    difference = first - second
    finite = np.isfinite(unit)
    median = float(np.median(unit[finite])) if finite.any() else 1.0
    counts = finite | (difference != 0)
    scaled = difference[counts] / np.where(finite, unit, median)[counts]
    return float(np.sqrt(np.mean(scaled**2))) if scaled.size else 0.0
