"""Test-time augmentation, with models that record what they are shown."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.predictor import (
    CONFIDENT_DIFFERENT,
    MODELS,
    MaskPredictor,
)
from sensory_commutativity.change_detection.tta import (
    FLIPS,
    half_resolution,
    predict_half_resolution,
    predict_tta,
)
from tests.change_detection.examples import SMALL


class Brightness:
    """Predicts the brightness of each pixel as its logit."""

    def __init__(self):
        self.inputs: list[torch.Tensor] = []

    def __call__(self, pictures):
        self.inputs.append(pictures)
        return pictures.mean(2)


def smooth_pictures(n: int, side: int = 128) -> torch.Tensor:
    wave = torch.sin(torch.linspace(0, 3, side))
    brightness = torch.tensor([1.0, 0.5])[None, :, None, None, None]
    return (wave[:, None] * wave[None, :]).expand(n, 2, 3, side, side) * brightness


def changed(side: int, rows: slice, columns: slice) -> np.ndarray:
    """A map of one pair, (1, side, side), that changed in a rectangle."""
    changed = np.zeros((1, side, side), bool)
    changed[:, rows, columns] = True
    return changed


def test_flips_and_scales_predict_the_same_of_a_symmetric_model():
    for columns, side in ((slice(3, 20), 128), (slice(3, 100), 64)):
        model, pictures = Brightness(), smooth_pictures(2)
        where = changed(128, slice(100, 120), columns).repeat(2, 0)
        logits = predict_tta(model, pictures, where)
        assert torch.allclose(logits, pictures.mean(2), atol=0.02)
        assert len(model.inputs) == 2 * len(FLIPS) and model.inputs[-1].shape[-1] == side
    # pairs with a small change, a large one and none keep their order
    pictures = torch.arange(3.0)[:, None, None, None, None].expand(3, 2, 3, 128, 128)
    maps = [
        changed(128, slice(0, 9), slice(0, 9)),
        changed(128, slice(0, 128), slice(0, 9)),
        np.zeros((1, 128, 128), bool),
    ]
    logits = predict_tta(Brightness(), pictures, np.concatenate(maps))
    assert torch.allclose(logits, pictures.mean(2), atol=1e-5)


def test_a_small_change_is_enlarged():
    model, pictures = Brightness(), torch.zeros(1, 2, 3, 128, 128)
    pictures[0, 0, :, 10:20, 118:128] = 1.0
    logits = predict_tta(model, pictures, changed(128, slice(10, 20), slice(118, 128)))
    enlarged = float(model.inputs[len(FLIPS)][0, 0].mean())
    assert enlarged == pytest.approx(4 * float(pictures[0, 0].mean()), rel=0.05)
    assert logits[0, 0, 12:18, 120:126].min() > 0.95 and not logits[0, 1].any()


def test_prediction_at_half_the_resolution():
    model, pictures = Brightness(), smooth_pictures(2)
    assert torch.allclose(predict_half_resolution(model, pictures), pictures.mean(2), atol=0.02)
    assert len(model.inputs) == len(FLIPS) and model.inputs[-1].shape[-1] == 64
    assert half_resolution((128, 160)) == (64, 64)
    assert half_resolution((192, 128)) == (96, 64)
    assert half_resolution((128, 96)) is None
    with pytest.raises(ValueError, match="96 x 128 pixels cannot be halved"):
        predict_half_resolution(model, torch.zeros(1, 2, 3, 96, 128))
    model = Brightness()  # pictures that are too small are not halved
    predict_tta(model, smooth_pictures(1, 64), changed(64, slice(0, 64), slice(0, 64)))
    assert len(model.inputs) == len(FLIPS)


def test_every_model_takes_all_scales_of_pictures_that_are_not_square():
    everywhere = np.ones((1, 128, 160), bool)
    for name in MODELS:
        torch.manual_seed(0)
        predictor = MaskPredictor(name, MODELS[name](**SMALL[name]))
        with torch.inference_mode():
            x = torch.zeros(1, 2, 3, 128, 160)
            logits = predict_tta(predictor._logits, x, everywhere)
        assert logits.shape == (1, 2, 128, 160), name


class LeftShifted(torch.nn.Module):
    """Sees what is bright in the first picture, a pixel too far left; little in the second."""

    def forward(self, first, second):
        shifted = 20 * first.mean(1).roll(-1, -1)
        return [torch.stack([shifted, torch.full_like(shifted, -2.0)], 1)]


def test_predictions_are_symmetric_where_a_first_one_found_a_change():
    pictures = np.zeros((1, 2, 64, 64, 3), np.uint8)
    pictures[0, 1, 10:30, 20:40] = 255
    predictor = MaskPredictor("raft", LeftShifted())
    # the model alone sees nothing in the second picture, so there is no augmentation
    assert (predictor.predict_proba(pictures) < 0.5).all()
    swapped = pictures[:, ::-1]
    probabilities = predictor.predict_proba(swapped)
    mirrored = predictor.predict_proba(swapped[:, :, :, ::-1])
    assert (probabilities > 0.5).any()
    assert np.allclose(probabilities[..., ::-1], mirrored, atol=1e-6)


class UnsureDifferent(torch.nn.Module):
    """Predicts "different" with a given probability at 128 pixels, and "moved" at fewer."""

    def __init__(self, probability: float):
        super().__init__()
        self.logit = float(torch.logit(torch.tensor(probability)))
        self.sides: list[int] = []

    def forward(self, first, second):
        side = first.shape[-1]
        self.sides += [side] * len(first)
        logits = torch.full((len(first), 2, side, side), self.logit if side == 128 else -9.0)
        logits[:, :, :8, :8] = 9.0
        return [logits]


def test_pairs_that_are_hardly_different_are_predicted_at_half_the_resolution():
    for probability, unsure in ((CONFIDENT_DIFFERENT + 0.01, False), (0.85, True)):
        model = UnsureDifferent(probability)
        predictor = MaskPredictor("raft", model)
        maps = predictor.predict_proba(np.zeros((1, 2, 128, 128, 3), np.uint8))
        assert (maps.mean() < 0.1) == unsure
        assert model.sides == [128] + [64] * len(FLIPS) * unsure
    small = predictor.predict_proba(np.zeros((1, 2, 64, 64, 3), np.uint8))  # cannot be halved
    assert small.shape == (1, 2, 64, 64)
