"""From two maps of probabilities to an outcome and masks, and how good they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import label

from .outcome import MOVED, OUTCOMES, SEEN

MASK = 0.5
"""Probability from which a pixel belongs to a mask."""


class DecisionThresholds(NamedTuple):
    """How probabilities become one of three outcomes; set on pairs that are neither trained on nor tested on.

    Attributes
    ----------
    different : float
        Mean probability from which all is different.
    sure : float
        Probability from which a pixel counts towards `area`.
    area : float
        Pixels of 128 x 128, over both views, from which something moved.
    """

    different: float = 0.5
    sure: float = 0.7
    area: float = 16.0


def outcomes(probabilities: np.ndarray, rule: DecisionThresholds) -> np.ndarray:
    """Indices into OUTCOMES of maps float (n, 2, h, w): int8 (n,)."""
    height, width = probabilities.shape[2:]
    everything = probabilities.mean((1, 2, 3)) > rule.different
    something = (probabilities > rule.sure).sum((1, 2, 3)) >= rule.area * height * width / 128**2
    found = np.where(
        everything,
        OUTCOMES.index("different"),
        np.where(something, MOVED, OUTCOMES.index("identical")),
    )
    return found.astype(np.int8)


def remove_small_components(probabilities: np.ndarray, least: float = SEEN) -> np.ndarray:
    """The maps, float (n, 2, h, w), without specks: connected parts above MASK with less than `least` pixels of 128 x 128 become 0.

    So much must be in sight of a thing to count (:mod:`.outcome`).
    """
    found = probabilities.copy()
    least *= probabilities.shape[2] * probabilities.shape[3] / 128**2
    for image in found.reshape(-1, *probabilities.shape[2:]):
        parts, n = label(image > MASK)
        if n:
            small = np.bincount(parts.ravel()) < least
            image[small[parts] & (parts > 0)] = 0
    return found


def intersection_over_union(probabilities: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Jaccard index of each mask (paper, section IV-A, "Evaluation"), of maps float and true masks bool, both (n, 2, h, w).

    Returns
    -------
    float64 (n, 2)
        NaN where a view shows nothing that moved and nothing is predicted there, so that an empty view neither helps nor harms; 0 where something is.
    """
    predicted = probabilities > MASK
    both, either = (predicted & masks).sum((2, 3)), (predicted | masks).sum((2, 3))
    with np.errstate(invalid="ignore"):
        return np.where(either > 0, both / np.maximum(either, 1), np.nan)


def tune(probabilities: np.ndarray, truth: np.ndarray) -> DecisionThresholds:
    """The rule with the highest accuracy on pairs neither trained nor tested on; of equal ones the first. `truth`: indices into OUTCOMES, int (n,)."""
    rules = [
        DecisionThresholds(d, s, a)
        for d in (0.5, 0.4, 0.6, 0.3)
        for s in (0.7, 0.5, 0.6, 0.8, 0.9)
        for a in (16.0, 8.0, 12.0, 24.0, 32.0, 48.0)
    ]
    return max(rules, key=lambda rule: (outcomes(probabilities, rule) == truth).mean())


def quality(
    probabilities: np.ndarray, truth: np.ndarray, masks: np.ndarray, rule: DecisionThresholds
) -> tuple[float, float]:
    """Accuracy of the outcomes, and mean intersection over union where something moved, both in [0, 1]; NaN where nothing did.

    Parameters
    ----------
    probabilities : float (n, 2, h, w)
    truth : int (n,)
        Indices into OUTCOMES.
    masks : bool (n, 2, h, w)
    rule : DecisionThresholds
    """
    moved = truth == MOVED
    iou = intersection_over_union(probabilities[moved], masks[moved])
    return float((outcomes(probabilities, rule) == truth).mean()), float(
        np.nanmean(np.nanmean(iou, axis=1))
    )
