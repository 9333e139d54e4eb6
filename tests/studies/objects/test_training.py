"""Training of mask predictors: a killed training ends as one that was not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch
from click.testing import CliRunner
from PIL import Image

from sensory_commutativity.change_detection import decision
from sensory_commutativity.change_detection.models.view_classifier import CROP_CHANNELS, CROP_SIZE
from sensory_commutativity.change_detection.pair_files import Pairs, pairs_to_arrays, read_pairs
from sensory_commutativity.change_detection.predictor import (
    MODELS,
    MaskPredictor,
    load_predictor,
)
from sensory_commutativity.change_detection.simulated.pairs import Pair
from sensory_commutativity.change_detection.training import trainer as trainer_module
from sensory_commutativity.change_detection.training import view_classifier_trainer
from sensory_commutativity.change_detection.training.mask_trainer import MaskTrainer
from sensory_commutativity.change_detection.training.view_classifier_trainer import (
    Regions,
    ViewClassifierTrainer,
)
from sensory_commutativity.cli import main
from sensory_commutativity.errors import UserError
from sensory_commutativity.storage.arrays import read_arrays, write_arrays
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import Model
from sensory_commutativity.studies.objects.arrays.mask_pairs import mask_pairs
from sensory_commutativity.studies.objects.arrays.mask_regions import mask_regions
from sensory_commutativity.studies.objects.models.mask_predictor import (
    add_view_classifier,
    mask_predictor,
    read_regions,
)
from sensory_commutativity.studies.objects.models.mask_training import mask_training
from sensory_commutativity.studies.objects.tables.mask_curves import mask_curves
from tests.studies.examples import overlay

SIZE = 128


def make_pairs(n: int, seed: int) -> list[Pair]:
    """Noise, in turn of each outcome; a bright square moves in the pairs that are "moved"."""
    rng = np.random.default_rng(seed)
    pairs = []
    for i in range(n):
        pictures = np.repeat(rng.integers(60, 120, (1, SIZE, SIZE, 3)), 2, 0).astype(np.uint8)
        masks = np.zeros((2, SIZE, SIZE), bool)
        outcome = ("identical", "different", "moved")[i % 3]
        if outcome == "different":
            pictures[1], masks[:] = rng.integers(60, 120, pictures[1].shape), True
        elif outcome == "moved":
            for view in range(2):
                top, left = rng.integers(0, SIZE - 20, 2)
                masks[view, top : top + 20, left : left + 20] = True
                pictures[view][masks[view]] = 250
        pairs.append(Pair(pictures, masks, outcome, outcome))
    return pairs


@pytest.fixture
def config(default_config, monkeypatch) -> Config:
    """A small FlowNet-S, trained on one file of pairs of two cluttered scenes."""
    original = MODELS["flownet"]

    def make_small(**architecture):
        return original(**(architecture or {"scale": 0.05}))

    monkeypatch.setitem(MODELS, "flownet", make_small)
    return overlay(
        default_config,
        masks={
            "data": {"pairs": 4, "validation_pairs": 3, "pairs_per_scene": 2, "scenes_per_job": 2},
            "flownet": {"samples": 48, "batch_size": 4, "checkpoints": 3},
            "view_classifier": {"pairs": 1, "samples": 24, "batch_size": 4},
        },
    )


@pytest.fixture
def folder(config, tmp_path) -> Path:
    """A folder with made-up pairs, as mask_pairs writes them."""
    for seed, run in enumerate(("training", "validation"), 1):
        (shard,) = mask_pairs.shards.of_run(config, run)
        arrays, texts = pairs_to_arrays(make_pairs(9, seed), [0] * 6 + [1] * 3)
        metadata = runner.metadata_of(mask_pairs, config, shard)
        write_arrays(tmp_path / mask_pairs.file(shard).name, "mask_pairs", arrays, texts | metadata)
    return tmp_path


def train(model: Model, config: Config, inputs: list[Path], out: Path, curve: Path | None = None):
    shard = model.shards.find(config, "flownet")
    runner.write_product(model, config, inputs, out, shard, curve)


def train_model(config: Config, folder: Path, name: str) -> Path:
    """Train a model; folder/name/flownet.predictor, beside it its curve."""
    pairs = [folder / "training.1-of-1.h5", folder / "validation.1-of-1.h5"]
    out = folder / name / "flownet.predictor"
    train(mask_training, config, pairs, out, out.with_suffix(".parquet"))
    return out


def count_steps(monkeypatch, trainer, kill_at: tuple[int, ...]) -> list[int]:
    """Steps that a trainer takes; it is killed at the calls numbered in `kill_at`."""
    monkeypatch.setattr(trainer_module, "CHECKPOINT_SECONDS", 0.0)
    advance: Callable = trainer.advance
    steps: list[int] = []

    def killed(self) -> float:
        steps.append(self.step)
        if len(steps) in kill_at:
            raise KeyboardInterrupt
        return advance(self)

    monkeypatch.setattr(trainer, "advance", killed)
    return steps


def test_a_killed_training_ends_as_one_that_was_not(folder, config, monkeypatch, capsys):
    whole = train_model(config, folder, "whole")
    assert capsys.readouterr().err.count("validation: accuracy") == 3
    steps = count_steps(monkeypatch, MaskTrainer, kill_at=(3, 8))
    resumed = folder / "resumed" / "flownet.predictor"
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            train_model(config, folder, "resumed")
        assert not resumed.exists() and not resumed.with_suffix(".parquet").exists()
    train_model(config, folder, "resumed")
    assert steps == [0, 1, 2, 2, 3, 4, 5, 6, 6, 7, 8, 9, 10, 11]
    assert resumed.read_bytes() == whole.read_bytes()
    curves = [runner.read_shards(mask_curves, config, [path.with_suffix(".parquet")])[0]
              for path in (whole, resumed)]  # fmt: skip
    assert curves[0].equals(curves[1]) and curves[0]["step"].tolist() == [4, 8, 12]
    assert curves[0]["samples"].tolist() == [16, 32, 48]
    assert not list(folder.rglob(".*")), "checkpoints are left"


def test_a_curve_is_written_by_training_alone(folder, config):
    (shard,) = mask_curves.shards.of_run(config, "flownet")
    pairs = [folder / "training.1-of-1.h5", folder / "validation.1-of-1.h5"]
    with pytest.raises(UserError, match="train mask_training --run flownet"):
        runner.write_product(mask_curves, config, pairs, folder / "flownet.parquet", shard)


# ---- regions and view classifier --------------------------------------------------------------


def make_regions(n: int, seed: int = 0) -> Regions:
    crops = np.random.default_rng(seed).uniform(size=(n, CROP_CHANNELS, CROP_SIZE, CROP_SIZE))
    return Regions(crops.astype(np.float16), np.eye(n, 2, dtype=bool))


def add_classifier(config: Config, folder: Path, name: str, regions: Regions) -> Path:
    """Train a view classifier for the model folder/model/flownet.predictor on `regions`."""
    (shard,) = mask_regions.shards.of_run(config, "flownet")
    path, out = folder / mask_regions.file(shard).name, folder / name / "flownet.predictor"
    metadata = runner.metadata_of(mask_regions, config, shard)
    write_arrays(path, "mask_regions", regions._asdict(), metadata)
    inputs = [folder / "model" / "flownet.predictor", path, folder / "validation.1-of-1.h5"]
    train(mask_predictor, config, inputs, out)
    return out


def test_a_killed_view_classifier_ends_as_one_that_was_not(folder, config, monkeypatch):
    model = train_model(config, folder, "model")
    assert load_predictor(model).view_classifier is None
    monkeypatch.setattr(decision, "accuracy_and_iou", lambda *_: (0.5, 0.5))  # it does no harm
    whole = add_classifier(config, folder, "whole", make_regions(9))
    assert load_predictor(whole, "flownet").view_classifier is not None
    steps = count_steps(monkeypatch, ViewClassifierTrainer, kill_at=(4,))
    with pytest.raises(KeyboardInterrupt):
        add_classifier(config, folder, "resumed", make_regions(9))
    resumed = add_classifier(config, folder, "resumed", make_regions(9))
    assert steps == [0, 1, 2, 3, 3, 4, 5]
    assert resumed.read_bytes() == whole.read_bytes()
    assert not list(folder.rglob(".*")), "checkpoints are left"
    alone = add_classifier(config, folder, "alone", make_regions(0))
    assert load_predictor(alone).view_classifier is None  # there was no region to learn from


def test_regions_are_those_of_the_first_pairs_of_each_scene(folder, config, monkeypatch):
    model, seen = train_model(config, folder, "model"), []
    regions = make_regions(3)

    def label_regions(predictor: MaskPredictor, pictures: np.ndarray, masks: np.ndarray) -> Regions:
        seen.append((pictures, masks))
        return regions

    monkeypatch.setattr(view_classifier_trainer, "label_regions", label_regions)
    (shard,) = mask_regions.shards.of_run(config, "flownet")
    inputs = [model, folder / "training.1-of-1.h5"]
    out = folder / mask_regions.file(shard).name
    runner.write_product(mask_regions, config, inputs, out, shard)
    pairs = make_pairs(9, 1)
    moved = [pairs[2], pairs[8]]  # the first of scene 0, the only one of scene 1
    ((pictures, masks),) = seen
    assert np.array_equal(pictures, np.stack([pair.pictures for pair in moved]))
    assert np.array_equal(masks, np.stack([pair.masks for pair in moved]))
    read = read_regions(out, out)
    assert np.array_equal(read.crops, np.concatenate([regions.crops] * 2))
    assert np.array_equal(read.empty, np.concatenate([regions.empty] * 2))
    assert read_arrays(out, "mask_regions")[1]["units"] == "0-2"


class EmptyView(torch.nn.Module):
    """Says of every region that one view, 0 or 1, is empty."""

    def __init__(self, view: int):
        super().__init__()
        self.logits = torch.nn.Parameter(torch.where(torch.arange(2) == view, 9.0, -9.0))

    def forward(self, crops):
        return self.logits.expand(len(crops), 2)


def test_a_view_classifier_is_left_out_if_it_lowers_the_iou(capsys):
    pictures = np.zeros((2, 2, SIZE, SIZE, 3), np.uint8)
    masks = np.zeros((2, 2, SIZE, SIZE), bool)
    masks[:, 0, 10:30, 10:30] = True
    in_both = np.repeat(masks.any(1)[:, None], 2, 1).astype(np.float32)  # but is in the first alone
    pairs = Pairs(pictures, masks, np.full(2, 2, np.int8), ("moved",) * 2, np.zeros(2, np.int32))
    for empty, kept in ((1, True), (0, False)):
        predictor = MaskPredictor("flownet", MODELS["flownet"](scale=0.05))
        refined = add_view_classifier(predictor, EmptyView(empty), in_both, pairs)
        assert (predictor.view_classifier is not None) == kept
        assert np.array_equal(refined > 0.5, masks if kept else in_both > 0.5)
        note = "left out; show it more regions (masks.view_classifier.samples)"
        assert (note in capsys.readouterr().err) == (not kept)


def test_the_image_difference_is_tuned_alone(folder, config):
    shard = mask_predictor.shards.find(config, "difference")
    out = folder / "difference.predictor"
    runner.write_product(mask_predictor, config, [folder / "validation.1-of-1.h5"], out, shard)
    predictor = load_predictor(out, "difference")
    held_out = read_pairs(folder / "validation.1-of-1.h5")
    probabilities = predictor.predict_proba(held_out.pictures)
    assert predictor.thresholds == decision.tune_thresholds(probabilities, held_out.outcome)
    for pair in make_pairs(6, 7):
        if pair.outcome != "different":
            assert predictor.predict(*pair.pictures).outcome == pair.outcome


def test_a_trained_predictor_is_used_from_the_command_line(folder, config):
    model = train_model(config, folder, "model")
    for name, picture in zip("ab", make_pairs(3, 5)[2].pictures, strict=True):
        Image.fromarray(picture).save(folder / f"{name}.png")
    arguments = ["predict", folder / "a.png", folder / "b.png", "--predictor", model]
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exit_code == 0 and "b-moved.png" in result.output
    assert Image.open(folder / "b-moved.png").size == (2 * SIZE, SIZE)
