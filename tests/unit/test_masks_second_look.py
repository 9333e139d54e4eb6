"""The second look, with a made-up model that writes down what it is shown."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.predictor import MODELS, SURE, MaskPredictor
from sensory_commutativity.change_detection.tta import (
    WAYS,
    farther,
    predict_half_resolution,
    predict_tta,
)


class Brightness:
    """Sees what is bright."""

    def __init__(self):
        self.shown: list[torch.Tensor] = []

    def __call__(self, pictures):
        self.shown.append(pictures)
        return pictures.mean(2)


def smooth(n: int, side: int = 128) -> torch.Tensor:
    waves = torch.sin(torch.linspace(0, 3, side))
    return (waves[:, None] * waves[None, :]).expand(n, 2, 3, side, side) * torch.tensor([1.0, 0.5])[
        None, :, None, None, None
    ]


def changed(n: int, side: int, rows: slice, columns: slice) -> np.ndarray:
    found = np.zeros((n, side, side), bool)
    found[:, rows, columns] = True
    return found


@pytest.mark.parametrize(("columns", "sides"), [(slice(3, 20), 128), (slice(3, 100), 64)])
def test_another_scale_shows_the_same(columns, sides):
    see, pictures = Brightness(), smooth(2)
    logits = predict_tta(see, pictures, changed(2, 128, slice(100, 120), columns))
    assert torch.allclose(logits, pictures.mean(2), atol=0.02)
    assert len(see.shown) == 2 * len(WAYS) and see.shown[-1].shape[-1] == sides


def test_what_is_small_is_seen_nearer():
    see, pictures = Brightness(), torch.zeros(1, 2, 3, 128, 128)
    pictures[0, 0, :, 10:20, 118:128] = 1.0
    logits = predict_tta(see, pictures, changed(1, 128, slice(10, 20), slice(118, 128)))
    assert float(see.shown[len(WAYS)][0, 0].mean()) == pytest.approx(
        4 * float(pictures[0, 0].mean()), rel=0.05
    )
    assert logits[0, 0, 12:18, 120:126].min() > 0.95 and not logits[0, 1].any()


def test_pictures_that_cannot_be_halved_are_seen_as_they_are():
    see = Brightness()
    predict_tta(see, smooth(1, 64), changed(1, 64, slice(0, 64), slice(0, 64)))
    assert len(see.shown) == len(WAYS)


def test_pairs_of_either_kind_keep_their_places():
    pictures = torch.arange(3.0)[:, None, None, None, None].expand(3, 2, 3, 128, 128)
    where = np.concatenate(
        [
            changed(1, 128, slice(0, 9), slice(0, 9)),
            changed(1, 128, slice(0, 128), slice(0, 9)),
            np.zeros((1, 128, 128), bool),
        ]
    )
    assert torch.allclose(predict_tta(Brightness(), pictures, where), pictures.mean(2), atol=1e-5)


def test_a_look_from_farther():
    see, pictures = Brightness(), smooth(2)
    assert torch.allclose(predict_half_resolution(see, pictures), pictures.mean(2), atol=0.02)
    assert len(see.shown) == len(WAYS) and see.shown[-1].shape[-1] == 64
    with pytest.raises(ValueError, match="96 x 128 pixels cannot be halved"):
        predict_half_resolution(see, torch.zeros(1, 2, 3, 96, 128))
    assert (
        farther((128, 160)) == (64, 64)
        and farther((192, 128)) == (96, 64)
        and farther((128, 96)) is None
    )


@pytest.mark.parametrize("name", MODELS)
def test_every_model_can_look_again_at_pictures_that_are_not_square(name):
    torch.manual_seed(0)
    see = MaskPredictor(name, MODELS[name]())._see
    everywhere = changed(1, 128, slice(0, 128), slice(0, 128)).repeat(2, 2)[:, :, :160]
    with torch.inference_mode():
        assert predict_tta(see, torch.zeros(1, 2, 3, 128, 160), everywhere).shape == (
            1,
            2,
            128,
            160,
        )


class Doubtful(torch.nn.Module):
    """Says with a given probability that all is different, unless it is far away."""

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


@pytest.mark.parametrize(("probability", "looks_again"), [(SURE + 0.01, False), (SURE - 0.1, True)])
def test_what_only_just_seems_different_is_seen_from_farther(probability, looks_again):
    model = Doubtful(probability)
    found = MaskPredictor("raft", model).probabilities(np.zeros((1, 2, 128, 128, 3), np.uint8))
    assert (found.mean() < 0.1) == looks_again and model.sides == [
        128,
        *([64] * len(WAYS) if looks_again else []),
    ]
    small = MaskPredictor("raft", model).probabilities(
        np.zeros((1, 2, 64, 64, 3), np.uint8)
    )  # cannot be halved
    assert small.shape == (1, 2, 64, 64)
