"""The baseline of all models: an image difference that tolerates small shifts and exposure.

It has no weights and is not trained.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter

SHIFT = 1
"""Pixels by which content may be displaced without counting as a change: the camera's jitter."""
SCALE = 24.0
"""Difference in grey levels that gives a probability of .5; chosen: well above noise and
exposure."""
SLOPE = 8.0
"""Grey levels by which the difference must exceed SCALE for log-odds of 1; chosen."""
DIFFERENT_FRACTION = 0.35
"""Fraction of changed pixels above which the whole pair counts as different; chosen."""


def image_difference(pictures: np.ndarray) -> np.ndarray:
    """Return change probabilities, float32 (n, 2, h, w), of pictures, uint8 (n, 2, h, w, 3).

    The difference at a pixel is the smallest to any pixel within SHIFT in the other view.
    """
    probabilities = np.empty(pictures.shape[:4], np.float32)
    for pair, (first, second) in zip(probabilities, pictures.astype(np.float32), strict=True):
        gain = np.median((first.mean((0, 1)) + 1) / (second.mean((0, 1)) + 1))
        views = first, second * gain
        for k, (view, reference) in enumerate((views, views[::-1])):
            smooth = uniform_filter(_smallest_difference(view, reference), 3)
            pair[k] = 1 / (1 + np.exp(-(smooth - SCALE) / SLOPE))
        if (pair > 0.5).mean() > DIFFERENT_FRACTION:
            pair[:] = np.maximum(pair, 0.9)
    return probabilities


def _smallest_difference(view: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Largest colour difference of each pixel to the most similar one nearby in a reference.

    Pictures float32 (h, w, 3), differences float32 (h, w).
    """
    height, width = view.shape[:2]
    smallest = np.full((height, width), np.inf, np.float32)
    padded = np.pad(reference, ((SHIFT, SHIFT), (SHIFT, SHIFT), (0, 0)), mode="edge")
    for dy in range(2 * SHIFT + 1):
        for dx in range(2 * SHIFT + 1):
            shifted = padded[dy : dy + height, dx : dx + width]
            smallest = np.minimum(smallest, np.abs(view - shifted).max(-1))
    return smallest
