"""Training of the view classifier: labelled regions, recolouring and learning itself."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.models.view_classifier import (
    CROP_CHANNELS,
    CROP_SIZE,
    ViewClassifier,
)
from sensory_commutativity.change_detection.predictor import MaskPredictor, PredictorError
from sensory_commutativity.change_detection.training.trainer import TrainingSettings
from sensory_commutativity.change_detection.training.view_classifier_trainer import (
    Regions,
    ViewClassifierTrainer,
    _recolour,
    label_regions,
)


class BothViews(torch.nn.Module):
    """Puts what is bright in either view into both masks; "different" if all is bright."""

    def forward(self, first, second):
        return [20 * torch.stack([torch.maximum(first, second).mean(1)] * 2, 1)]


def make_bright_pairs(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Grey noise, and a bright square in one of both views.

    Returns pictures uint8 (n, 2, 64, 64, 3) and masks bool (n, 2, 64, 64).
    """
    rng = np.random.default_rng(seed)
    pictures = np.repeat(rng.integers(40, 90, (n, 1, 64, 64, 3)), 2, 1).astype(np.uint8)
    masks = np.zeros((n, 2, 64, 64), bool)
    for i in range(n):
        top, left = rng.integers(2, 40, 2)
        masks[i, rng.integers(2), top : top + 16, left : left + 16] = True
    pictures[masks] = 250
    return pictures, masks


def make_regions(n: int) -> Regions:
    return label_regions(MaskPredictor("raft", BothViews()), *make_bright_pairs(n))


def test_regions_are_labelled_by_the_true_masks():
    pictures, masks = make_bright_pairs(5)
    pictures[4] = 255  # predicted as different, so without regions
    predictor = MaskPredictor("raft", BothViews())
    regions = label_regions(predictor, pictures, masks)
    assert regions.crops.shape == (4, CROP_CHANNELS, CROP_SIZE, CROP_SIZE)
    assert regions.crops.dtype == np.float16
    assert np.array_equal(regions.empty, ~masks[:4].any((2, 3)))
    none = label_regions(predictor, np.zeros_like(pictures), masks)
    assert none.crops.shape == (0, CROP_CHANNELS, CROP_SIZE, CROP_SIZE)
    assert none.empty.shape == (0, 2)
    predictor.view_classifier = ViewClassifier(4)
    with pytest.raises(PredictorError, match="already has a view classifier"):
        label_regions(predictor, pictures, masks)


def test_colours_change_alike_in_both_pictures_and_not_outside_of_them():
    rgb = torch.rand(5, 6, 8, 8) - 0.5
    rgb[:, :, :3] = 0  # outside of the pictures
    rgb[:, 3:] = rgb[:, :3]
    recoloured = _recolour(rgb, np.random.default_rng(0))
    assert not recoloured[:, :, :3].any()
    assert torch.equal(recoloured[:, :3], recoloured[:, 3:])
    assert (recoloured[:, :, 3:] != rgb[:, :, 3:]).float().mean() > 0.9
    assert recoloured.abs().max() <= 1


def test_a_trained_classifier_corrects_a_model_unless_tta_is_off():
    settings = TrainingSettings(samples=960, batch_size=16, learning_rate=5e-3)
    trainer = ViewClassifierTrainer(make_regions(30), settings, seed=1, width=8)
    while not trainer.finished:
        trainer.advance()
    pictures, masks = make_bright_pairs(20, seed=9)
    wrong_view = masks[:, ::-1]
    predictor = MaskPredictor("raft", BothViews(), view_classifier=trainer.model)
    alone = predictor.predict_proba(pictures, tta=False)
    assert (alone[masks] > 0.5).all() and (alone[wrong_view] > 0.5).all()
    refined = predictor.predict_proba(pictures)
    assert (refined[masks] > 0.5).mean() > 0.9 and (refined[wrong_view] > 0.5).mean() < 0.1


def test_a_resumed_run_ends_with_the_same_weights():
    regions, settings = make_regions(6), TrainingSettings(samples=24, batch_size=4)

    def train(stop_at: int | None) -> dict[str, torch.Tensor]:
        trainer = ViewClassifierTrainer(regions, settings, seed=3, width=4)
        while not trainer.finished:
            trainer.advance()
            if trainer.step == stop_at:
                state = trainer.state_dict()
                trainer = ViewClassifierTrainer(regions, settings, seed=3, width=4)
                trainer.load_state_dict(state)
        return trainer.model.state_dict()

    expected, weights = train(None), train(4)
    assert all(torch.equal(weights[key], expected[key]) for key in expected)
