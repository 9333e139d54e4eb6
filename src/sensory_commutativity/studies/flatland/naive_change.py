"""The naive alternative (paper, appendix A): how much the sensors change when a degree of freedom
moves."""

from __future__ import annotations

import numpy as np

from .transitions import Transitions


def squared_change(transitions: Transitions) -> np.ndarray:
    """Mean squared difference of consecutive observations, averaged over each sequence.

    Returns
    -------
    float64 (sequences,), squared 8-bit colour
    """
    change = np.diff(transitions.observations.astype(np.float32), axis=1)
    return (change * change).mean(axis=(1, 2, 3), dtype=np.float64)


def mean_and_standard_error(per_sequence: np.ndarray) -> tuple[float, float]:
    """Mean over sequences and its standard error.

    A sequence is the unit, since its transitions are not independent.
    """
    error = per_sequence.std(ddof=1) / np.sqrt(len(per_sequence))
    return float(per_sequence.mean()), float(error)
