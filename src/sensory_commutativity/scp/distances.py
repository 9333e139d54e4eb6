"""Distances between two observations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

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
    ValueError
        If the shapes differ.
    """
    if first.shape != second.shape:
        raise ValueError(
            f"observations of different shapes cannot be compared: {first.shape} and {second.shape}"
        )
    difference = first.astype(np.float64) - second.astype(np.float64)
    return float(np.mean(difference * difference))
