"""Looking again at pairs in which something seems to have moved, and at those that seem different but might not be: test-time augmentation.

Nothing about a pair depends on which picture is the first, or on left and right, and things are seen best in the size in which most were learnt. So
what moved is seen in four ways, and from nearer or farther, so that it is neither tiny nor huge, and the logits are averaged. What is so near that
the pictures seem different is seen from farther alone. Most pairs need no second look, so it costs little.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

See = Callable[[Tensor], Tensor]
"""Pictures, float (n, 2, 3, h, w), to logits, float (n, 2, h, w)."""
SIDE_STEP, LEAST_SIDE = 32, 64
"""Pixels: sides of the pictures that models are shown are multiples of the first and no less than the second."""
WAYS = ((), (-1,), (1,), (1, -1))
"""Axes that are turned round, of pictures and of logits alike: none, as in a mirror, exchanged, both."""


def predict_tta(see: See, pictures: Tensor, changed: np.ndarray) -> Tensor:
    """Mean logits of several looks at pairs.

    Parameters
    ----------
    see : callable
    pictures : float (n, 2, 3, h, w)
    changed : bool (n, h, w)
        Where the first look saw something change, in either view. If that fits into half the height and width, the second scale is of that part
        alone, enlarged to twice its size, else of the whole at half the resolution, if models can be shown such.

    Returns
    -------
    float (n, 2, h, w)
    """
    sides = pictures.shape[-2:]
    half = tuple(side // 2 for side in sides)
    logits = _four_ways(see, pictures)
    boxes = [_box(image) for image in changed]
    near = [
        k
        for k, (top, bottom, left, right) in enumerate(boxes)
        if bottom - top <= half[0] and right - left <= half[1]
    ]
    far = sorted(set(range(len(boxes))) - set(near)) if farther(sides) else []
    if near:
        windows = [_window(boxes[k], sides, half) for k in near]
        parts = torch.stack(
            [
                pictures[k, :, :, rows, columns]
                for k, (rows, columns) in zip(near, windows, strict=True)
            ]
        )
        seen = _resized(_four_ways(see, _scaled(parts, sides)), half)
        for part, k, (rows, columns) in zip(seen, near, windows, strict=True):
            logits[k, :, rows, columns] = (logits[k, :, rows, columns] + part) / 2
    if far:
        logits[far] = (logits[far] + predict_half_resolution(see, pictures[far])) / 2
    return logits


def farther(sides: Sequence[int]) -> tuple[int, ...] | None:
    """Sides of pictures as from twice as far, rounded down to what models can be shown; None if that is less than they need."""
    found = tuple(side // 2 // SIDE_STEP * SIDE_STEP for side in sides)
    return found if min(found) >= LEAST_SIDE else None


def predict_half_resolution(see: See, pictures: Tensor) -> Tensor:
    """Mean logits, float (n, 2, h, w), of four looks at half the resolution. Raises ValueError if the pictures are too small for that."""
    sides = farther(pictures.shape[-2:])
    if sides is None:
        raise ValueError(
            f"pictures of {' x '.join(map(str, pictures.shape[-2:]))} pixels cannot be halved"
        )
    return _resized(_four_ways(see, _scaled(pictures, sides)), pictures.shape[-2:])


def _four_ways(see: See, pictures: Tensor) -> Tensor:
    return torch.stack([see(pictures.flip(way)).flip(way) for way in WAYS]).mean(0)


def _box(image: np.ndarray) -> tuple[int, int, int, int]:
    """Top, bottom, left and right of what is true in an image; all of it if nothing is."""
    rows, columns = np.nonzero(image)
    if not len(rows):
        return 0, image.shape[0], 0, image.shape[1]
    return int(rows.min()), int(rows.max()) + 1, int(columns.min()), int(columns.max()) + 1


def _window(
    box: tuple[int, int, int, int], sides: tuple[int, ...], half: tuple[int, ...]
) -> tuple[slice, slice]:
    """The part of half the height and width with a box in its middle, as far as the edges allow."""
    starts = [
        int(np.clip((low + high - part) // 2, 0, side - part))
        for low, high, side, part in zip(box[::2], box[1::2], sides, half, strict=True)
    ]
    return slice(starts[0], starts[0] + half[0]), slice(starts[1], starts[1] + half[1])


def _scaled(pictures: Tensor, sides: Sequence[int]) -> Tensor:
    """Pictures, float (n, 2, 3, h, w), of another size."""
    return _resized(pictures.flatten(0, 1), sides).unflatten(0, (-1, 2))


def _resized(images: Tensor, sides: Sequence[int]) -> Tensor:
    return functional.interpolate(
        images, tuple(sides), mode="bilinear", align_corners=False, antialias=True
    )
