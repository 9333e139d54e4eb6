"""From the change probabilities of a pair to its outcome, and the scores of both.

Probabilities are float arrays of shape (n, 2, h, w): for each of n pairs one map per view. They
are high where a view shows something that moved, and everywhere if the views differ altogether.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import label

from .outcome import MIN_VISIBLE_PIXELS, MOVED, OUTCOMES

MASK_THRESHOLD = 0.5
"""Probability above which a pixel belongs to a mask."""
REFERENCE_AREA = 128**2
"""Pixels of the pictures for which areas are given; areas scale with the size of the picture."""


class DecisionThresholds(NamedTuple):
    """Thresholds that turn probabilities into one of three outcomes.

    The defaults are chosen; :func:`tune_thresholds` fits them to validation pairs.

    Attributes
    ----------
    different : float
        Mean probability above which a pair is "different".
    changed_pixel : float
        Probability above which a pixel counts as changed.
    min_area : float
        Number of changed pixels in both views together, of REFERENCE_AREA each, from which a pair
        is "moved".
    """

    different: float = 0.5
    changed_pixel: float = 0.7
    min_area: float = 16.0


def classify_outcomes(probabilities: np.ndarray, thresholds: DecisionThresholds) -> np.ndarray:
    """Return the outcome of each pair as an index into OUTCOMES: int8 (n,)."""
    height, width = probabilities.shape[2:]
    n_changed = (probabilities > thresholds.changed_pixel).sum((1, 2, 3))
    is_moved = n_changed >= thresholds.min_area * height * width / REFERENCE_AREA
    is_different = probabilities.mean((1, 2, 3)) > thresholds.different
    same_view = np.where(is_moved, MOVED, OUTCOMES.index("identical"))
    return np.where(is_different, OUTCOMES.index("different"), same_view).astype(np.int8)


def remove_small_components(
    probabilities: np.ndarray, min_pixels: float = MIN_VISIBLE_PIXELS
) -> np.ndarray:
    """Set connected components above MASK_THRESHOLD to 0 if they are small.

    Parameters
    ----------
    probabilities : float (n, 2, h, w)
    min_pixels : float
        Smallest component to keep, in pixels of REFERENCE_AREA. By default the smallest object
        that counts as visible (:mod:`.outcome`).

    Returns
    -------
    float (n, 2, h, w)
    """
    cleaned = probabilities.copy()
    height, width = probabilities.shape[2:]
    min_pixels *= height * width / REFERENCE_AREA
    for view in cleaned.reshape(-1, height, width):
        components, n = label(view > MASK_THRESHOLD)
        if n:
            is_small = np.bincount(components.ravel()) < min_pixels
            view[is_small[components] & (components > 0)] = 0
    return cleaned


def intersection_over_union(probabilities: np.ndarray, masks: np.ndarray) -> np.ndarray:
    """Jaccard index of each predicted mask (paper, section IV-A, "Evaluation").

    Parameters
    ----------
    probabilities : float (n, 2, h, w)
    masks : bool (n, 2, h, w)
        True masks.

    Returns
    -------
    float64 (n, 2)
        NaN for a view in which nothing moved and nothing is predicted, so that an empty view
        neither raises nor lowers a mean; 0 if only one of the two masks is empty.
    """
    predicted = probabilities > MASK_THRESHOLD
    intersection = (predicted & masks).sum((2, 3))
    union = (predicted | masks).sum((2, 3))
    return np.where(union > 0, intersection / np.maximum(union, 1), np.nan)


def tune_thresholds(probabilities: np.ndarray, truth: np.ndarray) -> DecisionThresholds:
    """Return the thresholds of a grid with the highest accuracy; of equal ones the first.

    Use validation pairs: neither trained nor tested on. `truth`: indices into OUTCOMES, int (n,).
    """
    grid = [
        DecisionThresholds(different, changed_pixel, min_area)
        for different in (0.5, 0.4, 0.6, 0.3)
        for changed_pixel in (0.7, 0.5, 0.6, 0.8, 0.9)
        for min_area in (16.0, 8.0, 12.0, 24.0, 32.0, 48.0)
    ]
    return max(grid, key=lambda t: (classify_outcomes(probabilities, t) == truth).mean())


def accuracy_and_iou(
    probabilities: np.ndarray,
    truth: np.ndarray,
    masks: np.ndarray,
    thresholds: DecisionThresholds,
) -> tuple[float, float]:
    """Score predictions: accuracy of the outcomes, and mean IoU of the pairs that are "moved".

    Parameters
    ----------
    probabilities : float (n, 2, h, w)
    truth : int (n,)
        Indices into OUTCOMES.
    masks : bool (n, 2, h, w)
        True masks.
    thresholds : DecisionThresholds

    Returns
    -------
    accuracy, iou : float
        Both in [0, 1]; the IoU is NaN if no pair is "moved".
    """
    accuracy = (classify_outcomes(probabilities, thresholds) == truth).mean()
    moved = truth == MOVED
    iou = intersection_over_union(probabilities[moved], masks[moved])
    return float(accuracy), float(np.nanmean(np.nanmean(iou, axis=1)))
