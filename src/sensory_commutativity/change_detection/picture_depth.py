"""Pictures of more than 8 bits, or of floats, as 8-bit pictures.

Both pictures of a pair are scaled alike, so that only what differs between them differs
afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import UserError

DEPTHS = (8, 10, 12, 14, 16, 24, 32)
"""Bits per pixel of cameras and files."""
ALIKE = 2.0
"""Ratio of the brightest pixels up to which two pictures count as being of one depth. Chosen: two
bits differ by a factor of four."""


class DepthError(UserError):
    """The values of a picture cannot be understood as brightness."""


def to_8_bit(pictures: Sequence[np.ndarray], names: Sequence[str]) -> list[np.ndarray]:
    """Scale pictures of :func:`.read_photo` to uint8 (h, w, 3), deep ones by one range.

    The range of whole numbers is that of the least depth that holds them; floats are taken to run
    from 0 to 1 if they do, to 255 if they do, and else from the lowest to the highest of all.

    Raises
    ------
    DepthError
        Values are not finite, or the pictures are of different depths.
    """
    deep = [i for i, picture in enumerate(pictures) if picture.dtype != np.uint8]
    for i in deep:
        if not np.isfinite(pictures[i]).all():
            raise DepthError(f"{names[i]}: has pixels that are not finite; save it as 8-bit PNG")
    ranges = {i: _find_range(pictures[i]) for i in deep}
    low = min((found[0] for found in ranges.values()), default=0.0)
    high = max((found[1] for found in ranges.values()), default=255.0)
    for i in deep:
        brightest = [max(float(np.abs(pictures[k]).max()), 1e-12) for k in deep]
        if ranges[i] != (low, high) and max(brightest) > ALIKE * min(brightest):
            held = ", ".join(f"{names[k]} up to {pictures[k].max():g}" for k in deep)
            raise DepthError(
                f"{names[i]}: the pictures are of different depths ({held}); save both with the "
                "same number of bits"
            )
    return [
        picture if i not in ranges else _scale(picture, low, high)
        for i, picture in enumerate(pictures)
    ]


def _find_range(picture: np.ndarray) -> tuple[float, float]:
    """What is black and what is white in a picture, float64 (h, w)."""
    low, high = float(picture.min(initial=0.0)), float(picture.max(initial=0.0))
    if low < 0:
        return low, max(high, low + 1e-12)
    if (picture == np.round(picture)).all() and high > 1:
        bits = next((bits for bits in DEPTHS if high < 2**bits), None)
        return 0.0, high if bits is None else 2.0**bits - 1
    return 0.0, next((white for white in (1.0, 255.0) if high <= white), high)


def _scale(picture: np.ndarray, low: float, high: float) -> np.ndarray:
    grey = np.clip(np.round((picture - low) * (255 / (high - low))), 0, 255).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)
