"""The three outcomes of an SC-experiment on objects, from the simulator's ground truth.

The rule was fixed before any model was trained (paper, section II-F). A pair of pictures is

- *different* if the camera or the robot's arm ended in another pose and the pictures show it: the
  static scene shifts by more than MAX_SHIFT on average over the picture, or the robot's body
  covers or uncovers more than MAX_ARM_CHANGE of it;
- *moved* if it is not different, but shows an object that was displaced;
- *identical* otherwise.

With a field of view of 90 degrees, a camera that returns one degree off still gives an identical
pair and one that returns three degrees off a different one. With 45 degrees the limit is at about
0.7 degrees.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..worlds.apartment.scenes.scene import SEGMENTATION_IDS

if TYPE_CHECKING:  # the renderer is slow to import, and predictors need only OUTCOMES
    from ..worlds.apartment.rendering.camera import Camera, Picture

Outcome = Literal["identical", "different", "moved"]
OUTCOMES: tuple[Outcome, ...] = ("identical", "different", "moved")
MOVED = OUTCOMES.index("moved")
MAX_SHIFT = 2.0 / 128
"""Mean shift of the static scene, in picture heights, up to which two views count as the same.
Chosen: 2 pixels of 128, or 1.3 degrees of camera rotation at a field of view of 90 degrees; from
about there on, a person who flips between two pictures sees two views."""
MAX_ARM_CHANGE = 0.01
"""Fraction of the picture that the robot's body may cover in one view only. Chosen: a square of
13 x 13 pixels of 128 x 128, the size of a large object."""
MIN_VISIBLE_PIXELS = 12
"""Pixels of 128 x 128 from which an object counts as visible. Chosen: fewer are not distinguishable
from noise."""
MIN_OBJECT_SHIFT = 0.01
"""Metres from which an object counts as displaced. Chosen."""
MIN_OBJECT_ROTATION = math.radians(5)
"""Radians from which an object counts as displaced. Chosen."""
CAMERA_TOLERANCE = 1e-3
"""Tolerance of the elements of a camera's pose, in metres and sines, within which it is unchanged.
Chosen; matters only where no part of the static scene is in view."""


def measure_image_shift(
    picture: Picture, camera_pose: np.ndarray, other_pose: np.ndarray, camera: Camera
) -> float:
    """Mean shift of the static scene from one view to another, in picture heights.

    Every pixel of `picture` that shows a fixture is reprojected into the other view. A pixel's
    shift counts as one picture height at most, also if its point ends behind the camera.

    Parameters
    ----------
    picture : Picture
        Rendered from `camera_pose`.
    camera_pose, other_pose : float64 (4, 4)
        Frames of the camera in the world: x points forward, y left, z up.
    camera : Camera

    Returns
    -------
    float
        Infinite if no fixture stays in front of the camera.
    """
    ids = picture.segmentation
    height, width = ids.shape
    focal = height / 2 / math.tan(math.radians(camera.field_of_view) / 2)
    is_static = (ids >= SEGMENTATION_IDS["fixture"]) & (ids != SEGMENTATION_IDS["robot"])
    rows, columns = np.nonzero(is_static)  # (n,) each
    if not len(rows):
        unchanged = np.allclose(camera_pose, other_pose, atol=CAMERA_TOLERANCE)
        return 0.0 if unchanged else math.inf
    right = (columns + 0.5 - width / 2) / focal
    down = (rows + 0.5 - height / 2) / focal
    depth = picture.depth[rows, columns].astype(np.float64)
    points = np.stack([depth, -right * depth, -down * depth, np.ones_like(depth)])  # (4, n)
    x, y, z, _ = np.linalg.inv(other_pose) @ camera_pose @ points
    in_front = x > camera.near
    if not in_front.any():
        return math.inf
    x, y, z = x[in_front], y[in_front], z[in_front]
    shifts = np.hypot(-y / x - right[in_front], -z / x - down[in_front]) * focal  # pixels
    total = np.minimum(shifts, height).sum() + height * (~in_front).sum()
    return float(total) / len(rows) / height


def measure_arm_change(first: Picture, second: Picture) -> float:
    """Fraction of the picture that the robot's body covers in only one of two views."""
    robot = SEGMENTATION_IDS["robot"]
    return float(((first.segmentation == robot) != (second.segmentation == robot)).mean())


def displaced_objects(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Indices of the objects that moved by MIN_OBJECT_SHIFT or turned by MIN_OBJECT_ROTATION.

    Parameters
    ----------
    before, after : float64 (n, 7)
        Positions in metres, and rotations as quaternions (x, y, z, w).

    Returns
    -------
    int (k,)
    """
    shift = np.linalg.norm(before[:, :3] - after[:, :3], axis=1)
    rotation = 2 * np.arccos(np.clip(np.abs((before[:, 3:] * after[:, 3:]).sum(1)), 0, 1))
    return np.nonzero((shift >= MIN_OBJECT_SHIFT) | (rotation >= MIN_OBJECT_ROTATION))[0]


def mask_objects(first: Picture, second: Picture, objects: np.ndarray) -> np.ndarray:
    """Pixels that show the objects with the given indices, int (k,): bool (2, h, w)."""
    ids = np.asarray(objects, np.int64) + SEGMENTATION_IDS["movable"]
    return np.stack([np.isin(picture.segmentation, ids) for picture in (first, second)])


def label_pair(
    first: Picture,
    second: Picture,
    first_pose: np.ndarray,
    second_pose: np.ndarray,
    displaced: np.ndarray,
    camera: Camera,
) -> tuple[Outcome, np.ndarray]:
    """Label a pair of pictures with its outcome and its true masks.

    Parameters
    ----------
    first, second : Picture
    first_pose, second_pose : float64 (4, 4)
        Camera poses from which they were rendered.
    displaced : int (k,)
        Indices of the objects that moved in between (see :func:`displaced_objects`).
    camera : Camera

    Returns
    -------
    outcome : str
    masks : bool (2, h, w)
        Pixels that show a displaced object; all True if *different*, all False if *identical*.
    """
    height, width = first.segmentation.shape
    if (
        measure_image_shift(first, first_pose, second_pose, camera) > MAX_SHIFT
        or measure_arm_change(first, second) > MAX_ARM_CHANGE
    ):
        return "different", np.ones((2, height, width), bool)
    masks = mask_objects(first, second, displaced)
    if masks.sum((1, 2)).max() >= MIN_VISIBLE_PIXELS * height * width / 128**2:
        return "moved", masks
    return "identical", np.zeros((2, height, width), bool)
