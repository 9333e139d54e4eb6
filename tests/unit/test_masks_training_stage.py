"""The training of a model as a stage: killed, it goes on and ends as if nothing had been; its predictor is used from the command line."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from click.testing import CliRunner
from PIL import Image
from sensory_commutativity.studies.objects.data import mask_places

from sensory_commutativity.change_detection.models.view_classifier import CROP_CHANNELS, CROP_SIZE
from sensory_commutativity.change_detection.pair_files import Pairs, write_pairs
from sensory_commutativity.change_detection.predictor import MODELS, MaskPredictor, load_predictor
from sensory_commutativity.change_detection.simulated.pairs import Pair
from sensory_commutativity.change_detection.training import trainer as cycle
from sensory_commutativity.change_detection.training.mask_trainer import MaskTrainer
from sensory_commutativity.change_detection.training.view_classifier_trainer import (
    Regions,
    ViewClassifierTrainer,
)
from sensory_commutativity.cli import main
from sensory_commutativity.storage.arrays import write_arrays
from sensory_commutativity.storage.tables import read_table
from sensory_commutativity.studies.loading import load, validate
from sensory_commutativity.studies.objects.models import mask_model as mask_training
from sensory_commutativity.studies.objects.models import view_classifier as mask_judging
from tests.helpers import DEFAULT

SIZE = 128


def made_up(n: int, seed: int) -> list[Pair]:
    """Noise; in the second picture of every third pair a bright square somewhere else, in every third another noise."""
    rng = np.random.default_rng(seed)
    pairs = []
    for i in range(n):
        pictures = np.repeat(rng.integers(60, 120, (1, SIZE, SIZE, 3)), 2, 0).astype(np.uint8)
        masks = np.zeros((2, SIZE, SIZE), bool)
        outcome = ("identical", "different", "moved")[i % 3]
        if outcome == "different":
            pictures[1], masks[:] = rng.integers(60, 120, pictures[1].shape), True
        elif outcome == "moved":
            for k in range(2):
                top, left = rng.integers(0, SIZE - 20, 2)
                masks[k, top : top + 20, left : left + 20] = True
                pictures[k][masks[k]] = 250
        pairs.append(Pair(pictures, masks, outcome, outcome))
    return pairs


@pytest.fixture
def files(tmp_path):
    for name, seed in (("training", 1), ("validation", 2)):
        write_pairs(tmp_path / f"{name}.h5", made_up(9, seed), {})
    return tmp_path


@pytest.fixture
def config(monkeypatch):
    scale = MODELS["flownet"]
    monkeypatch.setitem(MODELS, "flownet", lambda **given: scale(**(given or {"scale": 0.05})))
    settings = load(DEFAULT).model_dump(mode="json")
    settings["masks"]["flownet"] |= {"samples": 48, "batch_size": 4, "checkpoints": 3}
    settings["masks"]["judge"] |= {"pairs": 2, "samples": 24, "batch_size": 4}
    return validate(settings)


def trained(files, config, name: str) -> None:
    mask_training.write_training(
        config,
        "flownet",
        [files / "training.h5"],
        [files / "validation.h5"],
        files / f"{name}.parquet",
        files / f"{name}.predictor",
    )


def test_a_killed_training_ends_as_one_that_was_not(files, config, monkeypatch, capsys):
    trained(files, config, "whole")
    assert capsys.readouterr().err.count("validation: accuracy") == 3
    monkeypatch.setattr(cycle, "CHECKPOINT_SECONDS", 0.0)
    advance, steps = MaskTrainer.advance, []

    def killed_twice(trainer: MaskTrainer) -> float:
        steps.append(trainer.step)
        if len(steps) in (3, 8):
            raise KeyboardInterrupt
        return advance(trainer)

    monkeypatch.setattr(MaskTrainer, "advance", killed_twice)
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            trained(files, config, "killed")
        assert not (files / "killed.predictor").exists() and not (files / "killed.parquet").exists()
    trained(files, config, "killed")
    assert steps == [0, 1, 2, 2, 3, 4, 5, 6, 6, 7, 8, 9, 10, 11]
    assert (files / "killed.predictor").read_bytes() == (files / "whole.predictor").read_bytes()
    assert read_table("mask_curves", files / "killed.parquet").equals(
        read_table("mask_curves", files / "whole.parquet")
    )
    assert not list(files.glob(".*")), "checkpoints are left"


def some_places(n: int, seed: int = 0) -> Regions:
    return Regions(
        np.random.default_rng(seed)
        .uniform(size=(n, CROP_CHANNELS, CROP_SIZE, CROP_SIZE))
        .astype(np.float16),
        np.eye(n, 2, dtype=bool),
    )


def refine_masks(files, config, name: str, places: str = "places") -> MaskPredictor:
    out = files / f"{name}.predictor"
    mask_judging.write_judged(
        config,
        "flownet",
        files / "model.predictor",
        [files / f"{places}.h5"],
        [files / "validation.h5"],
        out,
    )
    return load_predictor(out)


def test_a_killed_judging_ends_as_one_that_was_not(files, config, monkeypatch):
    trained(files, config, "model")
    assert load_predictor(files / "model.predictor").view_classifier is None
    write_arrays(files / "places.h5", "places", some_places(9)._asdict(), {})
    monkeypatch.setattr(
        mask_judging, "accuracy_and_iou", lambda *_: (0.5, 0.5)
    )  # what it is taught helps nobody
    assert refine_masks(files, config, "whole").view_classifier is not None
    monkeypatch.setattr(cycle, "CHECKPOINT_SECONDS", 0.0)
    advance, steps = ViewClassifierTrainer.advance, []

    def killed(trainer: ViewClassifierTrainer) -> float:
        steps.append(trainer.step)
        if len(steps) == 4:
            raise KeyboardInterrupt
        return advance(trainer)

    monkeypatch.setattr(ViewClassifierTrainer, "advance", killed)
    with pytest.raises(KeyboardInterrupt):
        refine_masks(files, config, "killed")
    refine_masks(files, config, "killed")
    assert steps == [0, 1, 2, 3, 3, 4, 5]
    assert (files / "killed.predictor").read_bytes() == (files / "whole.predictor").read_bytes()
    assert not list(files.glob(".*")), "checkpoints are left"


def test_places_are_found_in_the_first_pairs_in_which_something_moved(files, config, monkeypatch):
    trained(files, config, "model")
    shown, given = [], [some_places(3, seed=k) for k in range(2)]

    def seen(predictor: MaskPredictor, pictures: np.ndarray, masks: np.ndarray) -> Regions:
        shown.append((pictures, masks))
        return given[len(shown) - 1]

    monkeypatch.setattr(mask_places, "label_regions", seen)
    for name in "ab":
        mask_places.write_mask_places(
            config,
            "flownet",
            files / "model.predictor",
            files / "training.h5",
            files / f"{name}.h5",
        )
    moved = [pair for pair in made_up(9, 1) if pair.outcome == "moved"][:2]
    assert np.array_equal(shown[0][0], np.stack([pair.pictures for pair in moved]))
    assert np.array_equal(shown[0][1], np.stack([pair.masks for pair in moved]))
    kept = mask_places.read_places(files / "a.h5", files / "b.h5")
    assert all(
        np.array_equal(both, np.concatenate(parts))
        for both, *parts in zip(kept, *given, strict=True)
    )


class SaysEmpty(torch.nn.Module):
    """Says so of one view, 0 or 1, of every place."""

    def __init__(self, view: int):
        super().__init__()
        self.logits = torch.nn.Parameter(torch.where(torch.arange(2) == view, 9.0, -9.0))

    def forward(self, seen):
        return self.logits.expand(len(seen), 2)


@pytest.mark.parametrize(("view", "kept"), [(1, True), (0, False)])
def test_a_judge_is_kept_unless_it_harms(view, kept, capsys):
    pictures, masks = np.zeros((2, 2, SIZE, SIZE, 3), np.uint8), np.zeros((2, 2, SIZE, SIZE), bool)
    masks[:, 0, 10:30, 10:30] = True
    found = np.repeat(masks.any(1)[:, None], 2, 1).astype(
        np.float32
    )  # seen in both views, and is in the first alone
    predictor, pairs = (
        MaskPredictor("flownet", MODELS["flownet"](scale=0.05)),
        Pairs(pictures, masks, np.full(2, 2, np.int8), ("moved",) * 2),
    )
    after = mask_judging.given_a_judge(predictor, SaysEmpty(view), found, pairs)
    assert (predictor.view_classifier is not None) == kept
    assert np.array_equal(after > 0.5, masks if kept else found > 0.5)
    assert (
        "left out; show it more places (masks.view_classifier.samples)" in capsys.readouterr().err
    ) == (not kept)


def test_a_model_that_finds_no_place_gets_no_judge(files, config):
    trained(files, config, "model")
    write_arrays(
        files / "none.h5",
        "places",
        Regions(
            np.zeros((0, CROP_CHANNELS, CROP_SIZE, CROP_SIZE), np.float16), np.zeros((0, 2), bool)
        )._asdict(),
        {},
    )
    assert refine_masks(files, config, "alone", "none").view_classifier is None


def test_a_trained_predictor_from_the_command_line(files, config):
    trained(files, config, "model")
    assert load_predictor(files / "model.predictor", "flownet").name == "flownet"
    for name, picture in zip("ab", made_up(3, 5)[2].pictures, strict=True):
        Image.fromarray(picture).save(files / f"{name}.png")
    said = CliRunner().invoke(
        main,
        [
            "masks",
            "predict",
            str(files / "a.png"),
            str(files / "b.png"),
            "--predictor",
            str(files / "model.predictor"),
        ],
    )
    assert said.exit_code == 0 and "b-moved.png" in said.output
    assert Image.open(files / "b-moved.png").size == (2 * SIZE, SIZE)
