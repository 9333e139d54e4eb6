"""Test-time augmentation: average the logits of several predictions of a pair.

What moved depends neither on the order of the pictures nor on left and right, and models segment
objects best at the sizes most common in training. A pair in which something moved is therefore
predicted in four flips and at two scales: a small change is enlarged twice, a large one is shown
at half the resolution. A pair whose views only just seem different may show one very near object;
it is predicted at half the resolution alone. Most pairs need neither, so the mean cost is low.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

PredictLogits = Callable[[Tensor], Tensor]
"""Maps pictures, float (n, 2, 3, h, w), to logits, float (n, 2, h, w)."""
SIDE_MULTIPLE = 32
"""Models take pictures whose height and width are multiples of this, in pixels."""
MIN_SIDE = 64
"""Smallest height and width that models take, in pixels."""
FLIPS = ((), (-1,), (1,), (1, -1))
"""Axes to flip, the same for pictures and logits: -1 mirrors, 1 exchanges the two pictures."""


def predict_tta(predict_logits: PredictLogits, pictures: Tensor, changed: np.ndarray) -> Tensor:
    """Average logits over four flips and two scales.

    Parameters
    ----------
    predict_logits : callable
    pictures : float (n, 2, 3, h, w)
    changed : bool (n, h, w)
        Where a first prediction found a change in either view. If it fits into half the height
        and width, the second scale is a crop of that size around it, enlarged twice; otherwise
        the whole pair at half the resolution, if that is not below MIN_SIDE.

    Returns
    -------
    float (n, 2, h, w)
    """
    height, width = pictures.shape[-2:]
    crop = height // 2, width // 2
    logits = _predict_flips(predict_logits, pictures)
    boxes = [_bounding_box(image) for image in changed]
    small = [
        k
        for k, (top, bottom, left, right) in enumerate(boxes)
        if bottom - top <= crop[0] and right - left <= crop[1]
    ]
    if small:
        windows = [_centre_window(boxes[k], (height, width), crop) for k in small]
        crops = torch.stack(
            [pictures[k, :, :, rows, cols] for k, (rows, cols) in zip(small, windows, strict=True)]
        )
        enlarged = _resize_pictures(crops, (height, width))
        crop_logits = _resize(_predict_flips(predict_logits, enlarged), crop)
        for k, (rows, cols), of_crop in zip(small, windows, crop_logits, strict=True):
            logits[k, :, rows, cols] = (logits[k, :, rows, cols] + of_crop) / 2
    large = sorted(set(range(len(boxes))) - set(small))
    if large and half_resolution((height, width)):
        at_half = predict_half_resolution(predict_logits, pictures[large])
        logits[large] = (logits[large] + at_half) / 2
    return logits


def half_resolution(sides: Sequence[int]) -> tuple[int, ...] | None:
    """Return half of the height and width, rounded down to SIDE_MULTIPLE; None below MIN_SIDE."""
    halved = tuple(side // 2 // SIDE_MULTIPLE * SIDE_MULTIPLE for side in sides)
    return halved if min(halved) >= MIN_SIDE else None


def predict_half_resolution(predict_logits: PredictLogits, pictures: Tensor) -> Tensor:
    """Average logits, float (n, 2, h, w), over four flips at half the resolution.

    Raises ValueError for pictures that are too small to be halved.
    """
    height, width = pictures.shape[-2:]
    halved = half_resolution((height, width))
    if halved is None:
        raise ValueError(f"pictures of {height} x {width} pixels cannot be halved")
    logits = _predict_flips(predict_logits, _resize_pictures(pictures, halved))
    return _resize(logits, (height, width))


def _predict_flips(predict_logits: PredictLogits, pictures: Tensor) -> Tensor:
    return torch.stack([predict_logits(pictures.flip(axes)).flip(axes) for axes in FLIPS]).mean(0)


def _bounding_box(image: np.ndarray) -> tuple[int, int, int, int]:
    """Top, bottom, left and right of the true pixels; the whole image if there are none."""
    rows, cols = np.nonzero(image)
    if not len(rows):
        return 0, image.shape[0], 0, image.shape[1]
    return int(rows.min()), int(rows.max()) + 1, int(cols.min()), int(cols.max()) + 1


def _centre_window(
    box: tuple[int, int, int, int], sides: tuple[int, int], crop: tuple[int, int]
) -> tuple[slice, slice]:
    """Rows and columns of a window of size `crop`, centred on a box but inside the picture."""
    top, left = (
        int(np.clip((low + high - extent) // 2, 0, side - extent))
        for low, high, side, extent in zip(box[::2], box[1::2], sides, crop, strict=True)
    )
    return slice(top, top + crop[0]), slice(left, left + crop[1])


def _resize_pictures(pictures: Tensor, sides: Sequence[int]) -> Tensor:
    """Resize pictures, float (n, 2, 3, h, w)."""
    return _resize(pictures.flatten(0, 1), sides).unflatten(0, (-1, 2))


def _resize(images: Tensor, sides: Sequence[int]) -> Tensor:
    """Resize images, float (n, c, h, w), bilinearly without aliasing."""
    return F.interpolate(images, tuple(sides), mode="bilinear", align_corners=False, antialias=True)
