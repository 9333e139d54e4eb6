"""In which of two pictures is what moved? A small network that judges each connected place as a whole.

A place is here a connected part of the picture, the same in both views. Models see well where something changed, and less well in which of the two
views it is: part of a thing, or all of it, is put into the view that shows what is behind it. To tell takes the whole place at once: a thing has an
outline and colours of its own, and what is behind it goes on under that outline. So of each connected place that has changed the judge sees a
close-up of both pictures and of what the model made of them, and says of each view whether it shows nothing there that moved. It learns from pairs
that the model is shown (:mod:`.judging`).
"""

from __future__ import annotations

import numpy as np
import torch
from scipy.ndimage import find_objects, label
from torch import Tensor, nn
from torchvision.ops import roi_align

from ..decision import MASK

SIDE = 48
"""Pixels of a close-up, in height and width; chosen on development tuples against 32 (docs/differences.md)."""
ROOM, LEAST = 1.7, 16
"""A close-up shows so many times the longer side of a place, so that its surroundings are in sight, and so many pixels of the pictures at least;
chosen, not tuned."""
CHANNELS = 9
"""Of a close-up: red, green and blue of either picture in [-1, 1], the map of either view and the place in [0, 1]; 0 outside of the picture."""
EMPTY = 0.5
"""Probability from which a view is taken to show nothing that moved."""
_SQUARE = np.ones((3, 3))


class ViewClassifier(nn.Module):
    """Close-ups to logits that a view shows nothing that moved there; one network for either view, which sees the other beside it.

    Parameters
    ----------
    width : int
        Channels of its first two convolutions; the next two have twice, the last two three times as many.
    """

    def __init__(self, width: int = 32):
        super().__init__()
        self.architecture = dict(width=width)
        shrink = nn.MaxPool2d(2)
        first, second = _stage(CHANNELS + 3, width), _stage(width, 2 * width)
        third = _stage(2 * width, 3 * width)
        self.view = nn.Sequential(
            *first, shrink, *second, shrink, *third, nn.AdaptiveAvgPool2d(1), nn.Flatten()
        )
        self.verdict = nn.Sequential(nn.Dropout(0.3), nn.Linear(6 * width, 1))

    def forward(self, crop_regions: Tensor) -> Tensor:
        """float (k, CHANNELS, SIDE, SIDE): float (k, 2)."""
        first, second, maps, place = crop_regions.split((3, 3, 2, 1), 1)
        difference = (first - second).abs()
        views = [
            (first, second, difference, maps, place),
            (second, first, difference, maps.flip(1), place),
        ]
        seen = self.view(torch.cat([torch.cat(view, 1) for view in views]))
        one, other = seen.chunk(2)
        return torch.cat(
            [self.verdict(torch.cat(both, 1)) for both in ((one, other), (other, one))], 1
        )


def changed_regions(maps: np.ndarray) -> list[np.ndarray]:
    """Connected places that have changed in either view, bool (h, w) each, of maps float (2, h, w); none where all seems different."""
    if maps.mean() > MASK:
        return []
    parts, n = label((maps > MASK).any(0), _SQUARE)
    return [parts == k + 1 for k in range(n)]


def crop_regions(maps: np.ndarray, pictures: np.ndarray, places: list[np.ndarray]) -> Tensor:
    """What the judge sees of places, at least one, of one pair.

    Parameters
    ----------
    maps : float (2, h, w)
    pictures : uint8 (2, h, w, 3)
    places : list of bool (h, w)

    Returns
    -------
    float32 (k, CHANNELS, SIDE, SIDE)
    """
    shown = np.concatenate(
        [pictures.transpose(0, 3, 1, 2).reshape(6, *maps.shape[1:]) / 127.5 - 1, maps]
    )
    layers = torch.from_numpy(
        np.stack([np.concatenate([shown, place[None]]) for place in places]).astype(np.float32)
    )
    boxes = torch.tensor(
        [[k, *_square(place)] for k, place in enumerate(places)], dtype=torch.float32
    )
    return roi_align(layers, boxes, SIDE, aligned=True)


def refine_masks(
    judge: ViewClassifier, probabilities: np.ndarray, pictures: np.ndarray
) -> np.ndarray:
    """Maps without doubts about which view a thing is in.

    Where the judge finds that a view shows nothing, all of the place goes to the other view; where it finds so of both, to neither.

    Parameters
    ----------
    judge : ViewClassifier
    probabilities : float (n, 2, h, w)
    pictures : uint8 (n, 2, h, w, 3)

    Returns
    -------
    float (n, 2, h, w)
    """
    found = probabilities.copy()
    for maps, pair in zip(found, pictures, strict=True):
        places = changed_regions(maps)
        if not places:
            continue
        for place, empty in zip(
            places, emptiness(judge, crop_regions(maps, pair, places)) > EMPTY, strict=True
        ):
            if empty.any():
                maps[:, place] = np.where(empty[:, None], 0, maps[:, place].max(0))
    return found


def emptiness(judge: ViewClassifier, seen: Tensor) -> np.ndarray:
    """Probability that a view shows nothing that moved, float (k, 2), of close-ups as they are and as in a mirror."""
    seen = seen.to(next(judge.parameters()).device)
    with torch.inference_mode():
        logits = (judge(seen) + judge(seen.flip(-1))) / 2
    return torch.sigmoid(logits).cpu().numpy()


def exchanged(seen: Tensor) -> Tensor:
    """Close-ups, float (k, CHANNELS, h, w), as if the pictures had come in the other order."""
    first, second, maps, place = seen.split((3, 3, 2, 1), 1)
    return torch.cat([second, first, maps.flip(1), place], 1)


def _square(place: np.ndarray) -> tuple[float, float, float, float]:
    """Left, top, right and bottom, pixels, of what a close-up shows."""
    rows, columns = find_objects(place.astype(int))[0]
    half = max(LEAST, ROOM * max(rows.stop - rows.start, columns.stop - columns.start)) / 2
    row, column = (rows.start + rows.stop) / 2, (columns.start + columns.stop) / 2
    return column - half, row - half, column + half, row + half


def _stage(inputs: int, outputs: int) -> list[nn.Module]:
    """Two convolutions."""
    widths = ((inputs, outputs), (outputs, outputs))
    return [
        layer
        for one, other in widths
        for layer in (nn.Conv2d(one, other, 3, 1, 1, bias=False), nn.BatchNorm2d(other), nn.ReLU())
    ]
