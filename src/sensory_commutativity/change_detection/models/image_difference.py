"""The baseline below all models: an image difference that tolerates small shifts and changes of exposure. It learns nothing."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter

SHIFT = 1
"""Pixels by which content may be displaced without counting as a change; as far as the jitter of a camera goes."""
SCALE = 24.0
"""Grey levels of difference that make a probability of a half; chosen: well above noise and exposure."""
SLOPE = 8.0


def difference(pictures: np.ndarray) -> np.ndarray:
    """Probability of change at every pixel of both pictures: float32 (n, 2, h, w), of pictures uint8 (n, 2, h, w, 3)."""
    found = np.empty(pictures.shape[:4], np.float32)
    for n, (first, second) in enumerate(pictures.astype(np.float32)):
        gain = np.median((first.mean((0, 1)) + 1) / (second.mean((0, 1)) + 1))
        for k, (a, b) in enumerate(((first, second * gain), (second * gain, first))):
            least = np.full(a.shape[:2], np.inf, np.float32)
            padded = np.pad(b, ((SHIFT, SHIFT), (SHIFT, SHIFT), (0, 0)), mode="edge")
            for dy in range(2 * SHIFT + 1):
                for dx in range(2 * SHIFT + 1):
                    shifted = padded[dy : dy + a.shape[0], dx : dx + a.shape[1]]
                    least = np.minimum(least, np.abs(a - shifted).max(-1))
            smooth = uniform_filter(least, 3)
            found[n, k] = 1 / (1 + np.exp(-(smooth - SCALE) / SLOPE))
        if (found[n] > 0.5).mean() > 0.35:  # most of the picture changed: another view
            found[n] = np.maximum(found[n], 0.9)
    return found
