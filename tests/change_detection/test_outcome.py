"""The outcome and the masks of a pair follow from poses, objects and segmentation."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sensory_commutativity.change_detection.outcome import (
    MIN_VISIBLE_PIXELS,
    displaced_objects,
    label_pair,
    mask_objects,
    measure_arm_change,
    measure_image_shift,
)
from sensory_commutativity.worlds.apartment import frames as fr
from sensory_commutativity.worlds.apartment.rendering.camera import Camera, Picture
from sensory_commutativity.worlds.apartment.scenes.scene import SEGMENTATION_IDS

CAMERA = Camera(128, 128, 90.0)
NO_OBJECTS = np.array([], int)


def wall(content: str = "fixture") -> Picture:
    """A wall two metres ahead."""
    return Picture(
        np.zeros((128, 128, 3), np.uint8),
        np.full((128, 128), SEGMENTATION_IDS[content], np.int32),
        np.full((128, 128), 2.0, np.float32),
    )


def yaw(degrees: float) -> np.ndarray:
    return fr.rotation(np.array([0.0, 0.0, 1.0]), math.radians(degrees))


def label(first: Picture, second: Picture, objects=NO_OBJECTS, degrees: float = 0.0):
    return label_pair(first, second, np.eye(4), yaw(degrees), np.asarray(objects), CAMERA)


def test_image_shift_follows_from_the_angle_of_a_rotating_camera():
    assert measure_image_shift(wall(), np.eye(4), np.eye(4), CAMERA) == pytest.approx(0, abs=1e-12)
    for degrees in (0.5, 1.0, 2.0):
        shift = measure_image_shift(wall(), np.eye(4), yaw(degrees), CAMERA) * 128
        in_centre = 64 * math.radians(degrees)  # pixels; towards the edges up to twice as many
        assert in_centre < shift < 2 * in_centre, degrees
    assert math.isinf(measure_image_shift(wall(), np.eye(4), yaw(180), CAMERA))
    for degrees, shift in ((0.0, 0.0), (0.01, 0.0), (1.0, math.inf)):
        for content in ("nothing", "movable", "robot"):  # no fixture in view: poses are compared
            assert measure_image_shift(wall(content), np.eye(4), yaw(degrees), CAMERA) == shift


def test_a_camera_or_an_arm_that_ends_elsewhere_makes_a_pair_different():
    for degrees, expected in ((0.0, False), (0.5, False), (3.0, True), (90.0, True)):
        outcome, masks = label(wall(), wall(), degrees=degrees)
        assert outcome == ("different" if expected else "identical"), degrees
        assert masks.shape == (2, 128, 128) and (masks == expected).all(), degrees
    first, second = wall(), wall()
    first.segmentation[:20, :20] = SEGMENTATION_IDS["robot"]
    second.segmentation[:20, 20:40] = SEGMENTATION_IDS["robot"]
    assert measure_arm_change(first, second) == pytest.approx(800 / 128**2)
    assert label(first, second)[0] == "different"
    assert label(first, first)[0] == "identical"


def test_displaced_objects_are_masked_where_each_view_shows_them():
    first, second = wall(), wall()
    first.segmentation[10:20, 10:20] = SEGMENTATION_IDS["movable"] + 3
    second.segmentation[40:44, 10:20] = SEGMENTATION_IDS["movable"] + 3
    outcome, masks = label(first, second, [3])
    assert outcome == "moved" and masks.sum((1, 2)).tolist() == [100, 40]
    assert np.array_equal(masks, mask_objects(first, second, np.array([3])))
    assert label(first, second, [2])[0] == "identical"
    assert label(first, second, [3], degrees=5)[0] == "different"
    for pixels, expected in ((MIN_VISIBLE_PIXELS - 1, "identical"), (MIN_VISIBLE_PIXELS, "moved")):
        first = wall()
        first.segmentation[0, :pixels] = SEGMENTATION_IDS["movable"]
        assert label(first, wall(), [0])[0] == expected, pixels


def test_objects_are_displaced_from_a_centimetre_or_five_degrees():
    before = np.array([[0, 0, 0, 0, 0, 0, 1.0]] * 6)
    after = before.copy()
    after[1, 0], after[2, 0] = 0.009, 0.011
    for i, degrees in ((3, 6), (4, 4)):
        half = math.radians(degrees / 2)
        after[i, 3:] = [0, 0, math.sin(half), math.cos(half)]
    after[5, 3:] *= -1  # the same rotation
    assert displaced_objects(before, after).tolist() == [2, 3]
