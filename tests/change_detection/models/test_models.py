"""The models: two masks of the right size, and a tolerant image difference."""

from __future__ import annotations

import numpy as np
import torch

from sensory_commutativity.change_detection.decision import DecisionThresholds, classify_outcomes
from sensory_commutativity.change_detection.models.flownet import MaskFlowNet
from sensory_commutativity.change_detection.models.image_difference import image_difference
from sensory_commutativity.change_detection.models.raft import MaskRaft
from sensory_commutativity.change_detection.predictor import MODELS
from tests.change_detection.examples import DIFFERENT, SMALL


def test_models_predict_two_masks_several_times_and_use_all_parameters():
    for name in MODELS:
        model = MODELS[name](**SMALL[name])
        first, second = torch.rand(2, 2, 3, 64, 96)
        predictions = model(first, second)
        assert len(predictions) > 1
        for logits in predictions:
            assert logits.shape == (2, 2, 64, 96) and torch.isfinite(logits).all(), name
        sum(logits.mean() for logits in predictions).backward()
        assert all(parameter.grad is not None for parameter in model.parameters()), name

    # both have about as many parameters
    raft, flownet = (
        sum(parameter.numel() for parameter in model.parameters())
        for model in (MaskRaft(), MaskFlowNet())
    )
    assert 0.8 < raft / flownet < 1.25
    assert raft * 2 < 5e6  # bytes in half precision: small enough for the repository


def test_the_image_difference_tolerates_a_shift_of_a_pixel_and_exposure():
    rng = np.random.default_rng(1)
    picture = np.kron(rng.integers(40, 180, (16, 16, 3)), np.ones((8, 8, 1))).astype(np.uint8)
    shifted = np.clip(np.roll(picture, 1, 1) * 1.05, 0, 255).astype(np.uint8)
    changed = picture.copy()
    changed[20:60, 30:70] = 255 - changed[20:60, 30:70]
    other = rng.integers(0, 255, picture.shape).astype(np.uint8)
    pairs = np.stack([np.stack([picture, second]) for second in (shifted, changed, other)])
    probabilities = image_difference(pairs)
    assert (probabilities[0, :, 4:-4, 4:-4] > 0.5).mean() < 0.02
    assert (probabilities[1, :, 25:55, 35:65] > 0.5).mean() > 0.7
    assert not (probabilities[1, :, 80:, 80:] > 0.5).any()
    assert classify_outcomes(probabilities, DecisionThresholds())[2] == DIFFERENT
