"""Outcomes, masks and scores of hand-made probability maps."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.change_detection.decision import (
    DecisionThresholds,
    accuracy_and_iou,
    classify_outcomes,
    intersection_over_union,
    remove_small_components,
    tune_thresholds,
)
from tests.change_detection.examples import DIFFERENT, IDENTICAL, MOVED


def test_outcomes_by_hand():
    maps = np.zeros((4, 2, 128, 128))
    maps[1] = 0.9
    maps[2, 0, :4, :4] = 0.8
    maps[3, 0, :4, :3] = 0.8  # twelve pixels are too few for the default
    thresholds = DecisionThresholds(0.5, 0.7, 16)
    expected = [IDENTICAL, DIFFERENT, MOVED, IDENTICAL]
    assert classify_outcomes(maps, thresholds).tolist() == expected
    assert classify_outcomes(maps, DecisionThresholds(0.5, 0.7, 12)).tolist()[3] == MOVED
    # areas scale with the size of the pictures
    assert classify_outcomes(maps[:, :, ::2, ::2], thresholds).tolist()[:3] == expected[:3]


def test_small_components_are_removed_from_a_copy():
    maps = np.zeros((1, 2, 128, 128), np.float32)
    maps[0, 0, :3, :3] = 0.9
    maps[0, 0, 50:54, 50:54] = 0.9
    maps[0, 1, 0, 0] = 0.4  # below the threshold, so part of no component
    cleaned = remove_small_components(maps)
    assert (cleaned > 0.5).sum() == 16 and cleaned[0, 0, 50:54, 50:54].min() > 0.5
    assert cleaned[0, 1, 0, 0] == np.float32(0.4)
    assert (maps > 0.5).sum() == 9 + 16
    assert (remove_small_components(maps, 9) > 0.5).sum() == 9 + 16
    halved = remove_small_components(maps[:, :, ::2, ::2])  # areas scale with the picture
    assert (halved > 0.5).sum() == 2 * 2 + 2 * 2


def test_scores_by_hand_and_thresholds_with_the_highest_accuracy():
    truth, maps = np.zeros((1, 2, 8, 8), bool), np.zeros((1, 2, 8, 8))
    truth[0, 0, :4, :4] = True
    maps[0, 0, :4, :2] = 0.6
    iou = intersection_over_union(maps, truth)[0]
    assert iou.tolist() == pytest.approx([0.5, np.nan], nan_ok=True)
    maps[0, 1, 0, 0] = 1.0  # a prediction in an empty view counts against it
    assert intersection_over_union(maps, truth)[0].tolist() == [0.5, 0.0]
    maps = np.zeros((3, 2, 128, 128))
    maps[1] = 0.45
    maps[2, 0, :10, :10] = 0.65
    truth = np.array([IDENTICAL, DIFFERENT, MOVED])
    masks = maps > 0.5
    thresholds = tune_thresholds(maps, truth)
    assert accuracy_and_iou(maps, truth, masks, thresholds) == (1.0, 1.0)
    assert accuracy_and_iou(maps, truth, masks, DecisionThresholds()) == (1 / 3, 1.0)
