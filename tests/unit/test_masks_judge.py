"""The judge of places: what it is shown, what follows from what it says, and that it learns, a kill or not."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.change_detection.models.view_classifier import (
    CHANNELS,
    SIDE,
    ViewClassifier,
    changed_regions,
    crop_regions,
    emptiness,
    exchanged,
    refine_masks,
)
from sensory_commutativity.change_detection.predictor import MaskPredictor, PredictorError
from sensory_commutativity.change_detection.training.trainer import TrainingSettings
from sensory_commutativity.change_detection.training.view_classifier_trainer import (
    Regions,
    ViewClassifierTrainer,
    _recoloured,
    labelled_regions,
)


def one_pair(side: int = 64) -> tuple[np.ndarray, np.ndarray]:
    """Nothing seen in two grey pictures."""
    return np.zeros((2, side, side), np.float32), np.full((2, side, side, 3), 100, np.uint8)


class Told(torch.nn.Module):
    """Says of either view what it was told, whatever it is shown."""

    def __init__(self, *probabilities: float):
        super().__init__()
        self.logits = torch.nn.Parameter(torch.logit(torch.tensor([probabilities])))

    def forward(self, seen):
        return self.logits.expand(len(seen), -1)


def test_places_are_what_is_connected_over_both_views():
    maps, _ = one_pair()
    maps[0, 4:10, 4:10], maps[1, 10:14, 10:14], maps[1, 40:44, 40:44], maps[0, 60, 60] = (
        0.9,
        0.9,
        0.6,
        0.4,
    )
    found = changed_regions(maps)
    assert [int(place.sum()) for place in found] == [36 + 16, 16]
    assert changed_regions(np.zeros_like(maps)) == []


@pytest.mark.parametrize(
    ("top", "left", "height", "width"),
    [(20, 30, 8, 12), (0, 0, 10, 6), (54, 50, 10, 14), (10, 10, 40, 30)],
)
def test_a_close_up_shows_a_place_in_its_middle_and_nothing_outside_of_the_picture(
    top, left, height, width
):
    maps, pictures = one_pair()
    rows, columns = slice(top, top + height), slice(left, left + width)
    maps[0, rows, columns] = 1.0
    pictures[1, rows, columns] = (255, 0, 127)
    seen = crop_regions(maps, pictures, changed_regions(maps))
    assert seen.shape == (1, CHANNELS, SIDE, SIDE) and seen.dtype == torch.float32
    middle = seen[0, :, SIDE // 2, SIDE // 2]
    assert middle[:3].tolist() == pytest.approx([100 / 127.5 - 1] * 3, abs=1e-5)
    assert middle[3:6].tolist() == pytest.approx([1.0, -1.0, 0.0], abs=0.01)
    assert middle[6:].tolist() == pytest.approx([1.0, 0.0, 1.0], abs=1e-5)
    shown = max(16.0, 1.7 * max(height, width))
    assert float(seen[0, 8].mean()) == pytest.approx(
        height * width / shown**2, rel=0.2
    )  # all of it is in sight
    beyond = top + height / 2 - shown / 2 < -1 - shown / SIDE
    assert beyond == bool((seen[0, :, 0] == 0).all())


def test_a_judge_says_of_pictures_in_the_other_order_the_same_of_the_other_view():
    torch.manual_seed(0)
    judge, seen = ViewClassifier(4).eval(), torch.rand(3, CHANNELS, SIDE, SIDE)
    judge.verdict[1].weight.data *= 1000  # untrained, it tells hardly anything apart
    seen[:, :3] = 0
    found = emptiness(judge, seen)
    assert found.shape == (3, 2) and (np.abs(found[:, 0] - found[:, 1]) > 0.01).all()
    assert np.allclose(emptiness(judge, exchanged(seen)), found[:, ::-1], atol=1e-3)
    assert np.allclose(emptiness(judge, seen.flip(-1)), found, atol=1e-3)


@pytest.mark.parametrize("empty", [(0.2, 0.4), (0.9, 0.2), (0.3, 0.6), (0.7, 0.8)])
def test_what_follows_from_a_verdict(empty):
    maps, pictures = one_pair()
    maps[0, 4:20, 4:20], maps[1, 4:12, 4:20], maps[1, 40:44, 40:44] = 0.9, 0.7, 0.8
    maps[:, 60, 60] = 0.3  # a doubt that is no place stays
    before = maps.copy()
    found = refine_masks(Told(*empty), maps[None], pictures[None])[0]
    assert np.array_equal(maps, before)
    for view in (0, 1):
        if max(empty) <= 0.5:
            assert np.array_equal(found[view], before[view])
        elif empty[view] > 0.5:
            assert not (found[view] > 0.5).any()
        else:
            assert (found[view, 4:20, 4:20] == np.float32(0.9)).all() and (
                found[view, 40:44, 40:44] == np.float32(0.8)
            ).all()
        assert found[view, 60, 60] == np.float32(0.3)
    assert not refine_masks(
        Told(0.9, 0.9), np.zeros((1, 2, 64, 64), np.float32), pictures[None]
    ).any()
    everything = np.full((1, 2, 64, 64), 0.9, np.float32)
    assert np.array_equal(
        refine_masks(Told(*empty), everything, pictures[None]), everything
    )  # another view stays one


class Both(torch.nn.Module):
    """Sees in both views what is bright in either; all as different where both are bright all over."""

    def forward(self, first, second):
        return [20 * torch.stack([torch.maximum(first, second).mean(1)] * 2, 1)]


def bright(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Grey noise, and in one of two pictures a bright square that the other does not show: pictures uint8 (n, 2, 64, 64, 3), masks bool."""
    rng = np.random.default_rng(seed)
    pictures = np.repeat(rng.integers(40, 90, (n, 1, 64, 64, 3)), 2, 1).astype(np.uint8)
    masks = np.zeros((n, 2, 64, 64), bool)
    for i in range(n):
        top, left = rng.integers(2, 40, 2)
        masks[i, rng.integers(2), top : top + 16, left : left + 16] = True
    pictures[masks] = 250
    return pictures, masks


def test_places_to_learn_from_are_labelled_by_the_true_masks():
    pictures, masks = bright(5)
    pictures[4] = 255  # taken for different: no place
    places = labelled_regions(MaskPredictor("raft", Both()), pictures, masks)
    assert (
        places.crop_regions.shape == (4, CHANNELS, SIDE, SIDE)
        and places.crop_regions.dtype == np.float16
    )
    assert np.array_equal(places.empty, ~masks[:4].any((2, 3)))
    none = labelled_regions(MaskPredictor("raft", Both()), np.zeros_like(pictures), masks)
    assert none.crop_regions.shape == (0, CHANNELS, SIDE, SIDE) and none.empty.shape == (0, 2)


def test_places_of_a_predictor_with_a_judge_are_refused():
    with pytest.raises(
        PredictorError, match="has a judge already; give the one that mask-training wrote"
    ):
        labelled_regions(MaskPredictor("raft", Both(), judge=ViewClassifier(4)), *bright(1))


def test_a_first_look_is_not_judged():
    pictures, _ = bright(2)
    predictor = MaskPredictor("raft", Both(), judge=Told(0.9, 0.9))
    assert (predictor.probabilities(pictures, again=False) > 0.5).any() and not (
        predictor.probabilities(pictures) > 0.5
    ).any()


def test_colours_change_alike_in_both_pictures_and_nothing_outside_of_them():
    pictures = torch.rand(5, 6, 8, 8) - 0.5
    pictures[:, :, :3] = 0
    pictures[:, 3:] = pictures[:, :3]
    found = _recoloured(pictures, np.random.default_rng(0))
    assert not found[:, :, :3].any() and torch.equal(found[:, :3], found[:, 3:])
    assert (found[:, :, 3:] != pictures[:, :, 3:]).float().mean() > 0.9 and found.abs().max() <= 1


def some_places(n: int, seed: int = 0) -> Regions:
    pictures, masks = bright(n, seed)
    return labelled_regions(MaskPredictor("raft", Both()), pictures, masks)


def test_a_judge_learns_which_view_shows_nothing_and_mends_what_a_model_says():
    trainer = ViewClassifierTrainer(
        some_places(30),
        TrainingSettings(samples=960, batch_size=16, learning_rate=5e-3),
        seed=1,
        width=8,
    )
    while not trainer.finished:
        trainer.advance()
    pictures, masks = bright(20, seed=9)
    alone = MaskPredictor("raft", Both()).probabilities(pictures)
    found = MaskPredictor("raft", Both(), judge=trainer.model).probabilities(pictures)
    assert (alone[masks[:, ::-1]] > 0.5).all()
    assert (found[masks] > 0.5).mean() > 0.9 and (found[masks[:, ::-1]] > 0.5).mean() < 0.1


def test_a_resumed_judge_ends_as_one_that_was_not():
    places, recipe = some_places(6), TrainingSettings(samples=24, batch_size=4)

    def run(stop_at: int | None) -> list[torch.Tensor]:
        trainer = ViewClassifierTrainer(places, recipe, seed=3, width=4)
        while not trainer.finished:
            trainer.advance()
            if trainer.step == stop_at:
                state = trainer.state()
                trainer = ViewClassifierTrainer(places, recipe, seed=3, width=4)
                trainer.resume(state)
        return list(trainer.model.state_dict().values())

    assert all(torch.equal(a, b) for a, b in zip(run(None), run(4), strict=True))
