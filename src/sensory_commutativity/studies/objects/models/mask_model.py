"""Models that learn to see what moved, and their curves (paper, section IV-A, "Architecture and training")."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from tqdm import tqdm

from ....change_detection.decision import DecisionThresholds, quality
from ....change_detection.pair_files import Pairs, read_pairs
from ....change_detection.predictor import MaskPredictor, best_device
from ....change_detection.training.mask_trainer import MaskTrainer
from ....change_detection.training.trainer import Row, fit, learning_rate
from ....errors import TableError
from ....storage.checkpoints import Checkpoint
from ....storage.provenance import package_versions, provenance
from ....storage.tables import read_table, write_table
from ...config import Config
from ..builders import recipe_of, settings_of_training, training_seed
from ..config import ModelName


def write_training(
    config: Config,
    model: ModelName,
    training: Sequence[Path],
    validation: Sequence[Path],
    out: Path,
    predictor: Path,
) -> None:
    """Train a model, or go on with it where it was killed; write its curve and itself, without a judge, its rule not tuned."""
    settings = config.masks.model(model)
    torch.set_num_threads(settings.threads)
    device = best_device()
    checkpoint = Checkpoint(
        out, f"{settings_of_training(config, model)} {device} {json.dumps(package_versions())}"
    )
    pairs, held_out = read_pairs(*training), read_pairs(*validation)
    trainer = MaskTrainer(model, recipe_of(config, model), pairs, training_seed(config), device)
    stops = np.unique(
        np.linspace(0, trainer.recipe.steps, settings.checkpoints + 1).round().astype(int)
    )[1:]

    def row(before: list[Row]) -> Row:
        found = _row(trainer, before, held_out)
        tqdm.write(_told(model, found, trainer.recipe.steps), file=sys.stderr)
        return found

    rows = fit(trainer, checkpoint, model, stops.tolist(), row)
    MaskPredictor(model, trainer.model, device=device).save(predictor, provenance(config))
    write_table("mask_curves", pd.DataFrame(rows).assign(model=model), out, config)
    checkpoint.forget()


def gather_curves(parts: Sequence[Path], out: Path, config: Config) -> None:
    """Put the curves of all models together. Raises TableError if one is there twice."""
    frame = pd.concat([read_table("mask_curves", part) for part in parts], ignore_index=True)
    if frame.duplicated(["model", "step"]).any():
        raise TableError(f"{out}: a model's curve is there twice; give each part once")
    write_table("mask_curves", frame, out, config)


def _told(model: ModelName, row: Row, steps: int) -> str:
    """A line for the log."""
    return f"{model}: step {row['step']:,} of {steps:,}, loss {row['loss']:.3f}; validation: accuracy {row['accuracy']:.3f}, mean IoU {row['iou']:.3f}"


def _row(trainer: MaskTrainer, rows: list[Row], held_out: Pairs) -> Row:
    """How far training has got, on pairs that it does not show, at first sight."""
    before = rows[-1]["step"] if rows else 0
    found = MaskPredictor(trainer.name, trainer.model, device=trainer.device).probabilities(
        held_out.pictures, again=False
    )
    accuracy, iou = quality(found, held_out.outcome, held_out.masks, DecisionThresholds())
    return dict(
        step=trainer.step,
        samples=trainer.step * trainer.recipe.batch_size,
        learning_rate=learning_rate(trainer.recipe, trainer.step - 1),
        loss=float(np.mean(trainer.losses[int(before) :])),
        accuracy=accuracy,
        iou=iou,
    )
