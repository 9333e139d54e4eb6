"""Which of the three outcomes a pair of pictures has, as only the simulator can tell (paper, section II-F).

The rule, fixed before anything was trained: the pair is *different* if the robot ended elsewhere, so that the picture shows it; *moved* if it did
not, but something that is in sight did; *identical* otherwise. Elsewhere means that what stands still is, on average over the picture, displaced by
more than MOST_SHIFT pixels (of 128), or that the robot's own arm covers or uncovers more than MOST_ARM of the picture. With a field of view of 90
degrees a camera that comes back a degree off is thus identical and three degrees off is different, with one of 45 degrees the limit is at about
seven tenths of a degree; in between the displacement decides.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from ..worlds.apartment.rendering.camera import Camera, Picture
from ..worlds.apartment.scenes.scene import IDENTITIES

Outcome = Literal["identical", "different", "moved"]
OUTCOMES: tuple[Outcome, ...] = ("identical", "different", "moved")
MOVED = OUTCOMES.index("moved")
MOST_SHIFT = 2.0 / 128
"""Mean displacement of what stands still, in heights of the picture; chosen: two pixels of 128, with a field of view of 90 degrees 1.3 degrees of
camera rotation, about where a person who flips between the pictures calls them two views."""
MOST_ARM = 0.01
"""Fraction of the picture that the robot's body covers in one view only; chosen: a square of 13 pixels a side, the size of a large object."""
STILL = 1e-3
"""Metres and sines within which a camera is where it was; taken only where nothing that stands still is in view."""
SEEN = 12
"""Pixels of 128 x 128 from which an object counts as in sight; chosen: less cannot be told from noise."""


def image_shift(first: Picture, eye: np.ndarray, other_eye: np.ndarray, camera: Camera) -> float:
    """Mean displacement, between two places of a camera, of what stands still, in heights of the picture; infinite if nothing of it stays in view.

    Parameters
    ----------
    first : Picture
        What is seen from `eye`.
    eye, other_eye : float64 (4, 4)
        Frames of the camera.
    """
    height, width = first.identity.shape
    focal = height / 2 / math.tan(math.radians(camera.field_of_view) / 2)
    rows, columns = np.nonzero(
        (first.identity >= IDENTITIES["fixture"]) & (first.identity != IDENTITIES["robot"])
    )
    if not len(rows):
        return 0.0 if np.allclose(eye, other_eye, atol=STILL) else math.inf
    right, down = (columns + 0.5 - width / 2) / focal, (rows + 0.5 - height / 2) / focal
    depth = first.depth[rows, columns].astype(np.float64)
    points = np.stack([depth, -right * depth, -down * depth, np.ones_like(depth)])
    there = np.linalg.inv(other_eye) @ eye @ points
    ahead = there[0] > camera.near
    if not ahead.any():
        return math.inf
    moved = (
        np.hypot(
            -there[1][ahead] / there[0][ahead] - right[ahead],
            -there[2][ahead] / there[0][ahead] - down[ahead],
        )
        * focal
    )
    return float(np.minimum(moved, height).sum() + height * (~ahead).sum()) / len(rows) / height


def arm_change(first: Picture, second: Picture) -> float:
    """Fraction of the picture that the robot's body covers in one of two views only."""
    return float(
        ((first.identity == IDENTITIES["robot"]) != (second.identity == IDENTITIES["robot"])).mean()
    )


def masks_of(first: Picture, second: Picture, moved: np.ndarray) -> np.ndarray:
    """Where the objects with the numbers `moved`, int (n,), are seen: bool (2, h, w)."""
    identities = np.asarray(moved, np.int64) + IDENTITIES["movable"]
    return np.stack([np.isin(picture.identity, identities) for picture in (first, second)])


def outcome_of(
    first: Picture,
    second: Picture,
    eye: np.ndarray,
    other_eye: np.ndarray,
    moved: np.ndarray,
    camera: Camera,
) -> tuple[Outcome, np.ndarray]:
    """The outcome of a pair and its true masks, bool (2, h, w): all true if different, none if identical; `moved`: numbers of the objects that
    moved."""
    height, width = first.identity.shape
    if (
        image_shift(first, eye, other_eye, camera) > MOST_SHIFT
        or arm_change(first, second) > MOST_ARM
    ):
        return "different", np.ones((2, height, width), bool)
    masks = masks_of(first, second, moved)
    if masks.sum((1, 2)).max() >= SEEN * height * width / 128**2:
        return "moved", masks
    return "identical", np.zeros((2, height, width), bool)
