"""In which of two pictures is what moved? Doubts of a model, settled for each connected place as a whole.

Models see well where something changed, and less well in which of the two views it is: part of a thing, or all of it, is put into the view that
shows what is behind it. Two things tell. A thing has an outline, and what is behind it goes on under that outline. And models are less certain of
what is not there.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation, binary_erosion, gaussian_gradient_magnitude, label

from .decision import MASK

SHARPER = 4.0
"""How much stronger an edge the outline of a place is in one picture than in the other, if what moved is surely in that picture alone."""
CERTAIN, STEEP = 0.8, 15.0
"""Mean probability of a mask from which it is more than doubt if the outline is as strong an edge in both pictures, and what a probability counts
against the logarithm of the ratio of edges. All chosen on development tuples (docs/differences.md)."""
NOISE = 2.0
"""Grey levels per pixel that are no edge, so that the ratio of two faint ones says little; chosen: those of a grey wall with a camera's noise."""
_SQUARE = np.ones((3, 3))


def settled(probabilities: np.ndarray, pictures: np.ndarray) -> np.ndarray:
    """Maps without doubts about which view a thing is in.

    Where a connected place has changed, all of it goes to the view in which its outline is an edge that is SHARPER times as strong as in the other.
    If there is none, it goes to the view of whose mask the model is more certain, unless it is certain of the other, too, the more so, the weaker
    the outline is there; then all stays as it is.

    Parameters
    ----------
    probabilities : float (n, 2, h, w)
    pictures : uint8 (n, 2, h, w, 3)

    Returns
    -------
    float (n, 2, h, w)
    """
    found = probabilities.copy()
    for maps, pair in zip(found, pictures, strict=True):
        parts, n = label((maps > MASK).any(0), _SQUARE)
        edges = np.stack([_edges(picture) for picture in pair])
        for part in range(1, n + 1):
            place = parts == part
            view = _view_of(place, maps, edges)
            if view is not None:
                maps[view, place] = maps[:, place].max(0)
                maps[1 - view, place] = 0
    return found


def _view_of(place: np.ndarray, maps: np.ndarray, edges: np.ndarray) -> int | None:
    """The view, 0 or 1, to which a place belongs alone, bool (h, w); None if to both. `maps` and `edges`: float (2, h, w)."""
    strength = np.log(edges[:, _outline(place)].mean(1) + NOISE)
    sharp = int(strength.argmax())
    if strength[sharp] - strength[1 - sharp] > np.log(SHARPER):
        return sharp
    masks = maps[:, place]
    certainty = [float(mask[mask > MASK].mean()) if (mask > MASK).any() else 0.0 for mask in masks]
    more = int(np.argmax(certainty))
    doubt = STEEP * (CERTAIN - certainty[1 - more]) + strength[more] - strength[1 - more]
    return more if doubt > 0 else None


def _outline(place: np.ndarray) -> np.ndarray:
    """A line three pixels thick along the outline of a place, bool (h, w); where it leaves the picture it has none, unless it fills the picture."""
    inside = binary_erosion(np.pad(place, 1, mode="edge"), _SQUARE)[1:-1, 1:-1]
    border = place & ~inside
    return binary_dilation(border if border.any() else place)


def _edges(picture: np.ndarray) -> np.ndarray:
    """Strength of edges, grey levels per pixel over all colours, float (h, w), of a picture uint8 (h, w, 3)."""
    colours = [gaussian_gradient_magnitude(picture[..., k].astype(np.float32), 1.0) for k in range(3)]
    return np.sqrt(np.sum(np.square(colours), axis=0))
