"""Training of the two-mask models: batches, crops, augmentation and learning itself."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.predictor import MODELS, to_tensor
from sensory_commutativity.change_detection.training.loss import mask_loss
from sensory_commutativity.change_detection.training.mask_trainer import (
    CENTRED_FRACTION,
    STAGES,
    MaskTrainer,
    augment,
    get_stage,
)
from sensory_commutativity.change_detection.training.trainer import TrainingSettings
from tests.change_detection.examples import IDENTICAL, MOVED, SMALL, make_pairs


def make_trainer(name: str, n: int = 6, **settings) -> MaskTrainer:
    return MaskTrainer(name, TrainingSettings(**settings), make_pairs(n), 3, **SMALL[name])


def test_a_model_learns_the_pairs_it_is_shown():
    trainer = make_trainer("raft", samples=900, batch_size=6, learning_rate=3e-3)
    x = to_tensor(trainer.pairs.pictures, "cpu")
    y = torch.from_numpy(trainer.pairs.masks).float()
    moved = torch.from_numpy(trainer.pairs.outcome == MOVED)

    def loss() -> float:
        with torch.no_grad():
            return float(mask_loss(trainer.model(x[:, 0], x[:, 1]), y, moved))

    before = loss()
    while not trainer.finished:
        trainer.advance()
    assert loss() < 0.75 * before


def test_a_resumed_run_ends_with_the_same_weights():
    def train(name: str, stop_at: int | None) -> MaskTrainer:
        trainer = make_trainer(name, samples=24, batch_size=4)
        while not trainer.finished:
            trainer.advance()
            if trainer.step == stop_at:
                state = trainer.state_dict()
                trainer = make_trainer(name, samples=24, batch_size=4)
                trainer.load_state_dict(state)
        assert len(trainer.losses) == trainer.settings.steps
        return trainer

    for name in MODELS:
        expected = train(name, None).model.state_dict()
        for stop_at in (1, 4):
            weights = train(name, stop_at).model.state_dict()
            assert all(torch.equal(weights[key], expected[key]) for key in expected), name


def test_batches_have_the_fractions_of_their_stage():
    # steps with crops show only pairs in which something moved
    trainer = make_trainer("flownet", 12, samples=4000, batch_size=64)
    kinds = set()
    for trainer.step in range(8):
        _, masks, moved = trainer._batch()
        # only batches that are not cropped hold pairs that differ everywhere
        whole = bool((masks > 0.5).flatten(1).all(1).any())
        kinds.add(whole)
        fraction = moved.float().mean()
        assert 0.4 < fraction < 0.8 if whole else fraction > 0.8
    assert kinds == {True, False}
    trainer = make_trainer("flownet", samples=24_000, batch_size=4)
    steps = trainer.settings.steps
    ends = [round(stage.end * steps) for stage in STAGES]
    assert ends[-1] == steps
    for stage, start, end in zip(STAGES, [0, *ends], ends, strict=False):
        assert get_stage(start, steps) == get_stage(end - 1, steps) == stage
        is_full, moved = [], []
        for trainer.step in range(start, start + 60):
            pictures, _, is_moved = trainer._batch()
            is_full.append(pictures.shape[-1] == 128)
            moved.append(float(is_moved.float().mean()) if is_full[-1] else np.nan)
        assert np.mean(is_full) == pytest.approx(stage.full, abs=0.2)
        assert any(is_full) == (stage.full > 0)
        if stage.full:
            assert np.nanmean(moved) == pytest.approx(stage.moved, abs=0.12)


def test_crops_lie_around_what_moved_and_show_the_same_part_of_pictures_and_masks():
    trainer = make_trainer("flownet", samples=400, batch_size=4)
    masks = np.zeros_like(trainer.pairs.masks)
    masks[:, :, 100:110, 20:30] = True
    pictures = np.where(masks[..., None], np.uint8(255), np.uint8(0)).repeat(3, -1)
    x, y = trainer._random_crops(pictures, masks, np.random.default_rng(1))
    assert x.shape == (len(masks), 2, 3, 64, 64) and y.shape == (len(masks), 2, 64, 64)
    shown = (y > 0.5).flatten(1).any(1).float().mean()
    assert shown > CENTRED_FRACTION - 0.1
    assert torch.allclose((x[:, :, 0] + 1) / 2, y, atol=1e-5)


def test_augmentation_changes_both_pictures_alike_and_keeps_masks_in_place():
    pairs = make_pairs(30)
    pictures, masks = augment(pairs.pictures, pairs.masks, np.random.default_rng(0))
    identical = pairs.outcome == IDENTICAL
    assert np.array_equal(pictures[identical, 0], pictures[identical, 1])
    assert (pictures != pairs.pictures).any((1, 2, 3, 4)).all()
    moved = pairs.outcome == MOVED
    assert (masks[moved].sum((1, 2, 3)) == 800).all()
    brightness = pictures[moved].astype(int).sum(-1)
    for image, mask in zip(brightness, masks[moved], strict=True):
        assert image[mask].mean() > image[~mask].mean() + 100
