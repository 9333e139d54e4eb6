"""View classifier: regions, crops, symmetry, and the masks that it refines."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.models.view_classifier import (
    CROP_CHANNELS,
    CROP_SIZE,
    ViewClassifier,
    changed_regions,
    crop_regions,
    predict_empty,
    refine_masks,
    swap_views,
)


def blank_pair(side: int = 64) -> tuple[np.ndarray, np.ndarray]:
    """Probabilities of 0, and two grey pictures."""
    return np.zeros((2, side, side), np.float32), np.full((2, side, side, 3), 100, np.uint8)


class Constant(torch.nn.Module):
    """Predicts the given probabilities that the views are empty, for every crop."""

    def __init__(self, *probabilities: float):
        super().__init__()
        self.logits = torch.nn.Parameter(torch.logit(torch.tensor([probabilities])))

    def forward(self, crops):
        return self.logits.expand(len(crops), -1)


def test_regions_are_connected_over_both_views():
    maps, _ = blank_pair()
    maps[0, 4:10, 4:10] = 0.9
    maps[1, 10:14, 10:14] = 0.9  # touches the first diagonally, in the other view
    maps[1, 40:44, 40:44] = 0.6
    maps[0, 60, 60] = 0.4
    assert [int(region.sum()) for region in changed_regions(maps)] == [36 + 16, 16]
    assert changed_regions(np.zeros_like(maps)) == []


def test_a_crop_is_centred_on_its_region_and_zero_outside_of_the_picture():
    for top, left, height, width in (
        (20, 30, 8, 12),
        (0, 0, 10, 6),
        (54, 50, 10, 14),
        (10, 10, 40, 30),
    ):
        maps, pictures = blank_pair()
        rows, columns = slice(top, top + height), slice(left, left + width)
        maps[0, rows, columns] = 1.0
        pictures[1, rows, columns] = (255, 0, 127)
        crops = crop_regions(maps, pictures, changed_regions(maps))
        assert crops.shape == (1, CROP_CHANNELS, CROP_SIZE, CROP_SIZE)
        assert crops.dtype == torch.float32
        centre = crops[0, :, CROP_SIZE // 2, CROP_SIZE // 2]
        assert centre[:3].tolist() == pytest.approx([100 / 127.5 - 1] * 3, abs=1e-5)
        assert centre[3:6].tolist() == pytest.approx([1.0, -1.0, 0.0], abs=0.01)
        assert centre[6:].tolist() == pytest.approx([1.0, 0.0, 1.0], abs=1e-5)
        extent = max(16.0, 1.7 * max(height, width))  # the whole region is in the crop
        assert float(crops[0, 8].mean()) == pytest.approx(height * width / extent**2, rel=0.2)
        beyond_the_top = top + height / 2 - extent / 2 < -1 - extent / CROP_SIZE
        assert beyond_the_top == bool((crops[0, :, 0] == 0).all())


def test_a_classifier_is_symmetric_in_both_views_and_under_mirroring():
    torch.manual_seed(0)
    classifier = ViewClassifier(4).eval()
    classifier.classifier[1].weight.data *= 1000  # untrained, it hardly tells crops apart
    crops = torch.rand(3, CROP_CHANNELS, CROP_SIZE, CROP_SIZE)
    crops[:, :3] = 0
    empty = predict_empty(classifier, crops)
    assert empty.shape == (3, 2) and (np.abs(empty[:, 0] - empty[:, 1]) > 0.01).all()
    assert np.allclose(predict_empty(classifier, swap_views(crops)), empty[:, ::-1], atol=1e-3)
    assert np.allclose(predict_empty(classifier, crops.flip(-1)), empty, atol=1e-3)


def test_masks_are_refined_by_which_views_are_empty():
    maps, pictures = blank_pair()
    maps[0, 4:20, 4:20] = 0.9
    maps[1, 4:12, 4:20] = 0.7
    maps[1, 40:44, 40:44] = 0.8
    maps[:, 60, 60] = 0.3  # below the threshold, so in no region
    before = maps.copy()
    everything = np.full((1, 2, 64, 64), 0.9, np.float32)
    for empty in ((0.2, 0.4), (0.9, 0.2), (0.3, 0.6), (0.7, 0.8)):
        classifier = Constant(*empty)
        refined = refine_masks(classifier, maps[None], pictures[None])[0]
        assert np.array_equal(maps, before), "the input has changed"
        for view in (0, 1):
            if max(empty) <= 0.5:
                assert np.array_equal(refined[view], before[view])
            elif empty[view] > 0.5:
                assert not (refined[view] > 0.5).any()
            else:
                assert (refined[view, 4:20, 4:20] == np.float32(0.9)).all()
                assert (refined[view, 40:44, 40:44] == np.float32(0.8)).all()
            assert refined[view, 60, 60] == np.float32(0.3)
        # a pair that is different everywhere has no regions
        assert np.array_equal(refine_masks(classifier, everything, pictures[None]), everything)
    nothing = np.zeros((1, 2, 64, 64), np.float32)
    assert not refine_masks(Constant(0.9, 0.9), nothing, pictures[None]).any()
