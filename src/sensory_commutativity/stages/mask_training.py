"""Models that learn to see what moved: training, curves, the decision rule (paper, section IV-A, "Architecture and training")."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from tqdm import tqdm

from ..checkpoints import Checkpoint
from ..config import Config, ModelName
from ..errors import TableError
from ..masks.decision import Rule, intersection_over_union, outcomes, tune
from ..masks.from_config import recipe_of, settings_of_training, training_seed
from ..masks.outcome import OUTCOMES
from ..masks.predictor import UNTRAINED, MaskPredictor, best_device
from ..masks.store import Pairs, read_pairs
from ..masks.training import Trainer, learning_rate
from ..provenance import package_versions, provenance
from ..tables import read_table, write_table

SAVED_EVERY = 45.0
"""Seconds between checkpoints: a kill loses so much."""
MOVED = OUTCOMES.index("moved")


def write_training(config: Config, model: ModelName, training: Sequence[Path], validation: Sequence[Path], out: Path, predictor: Path) -> None:
    """Train a model, or go on with it where it was killed; write its curve and, tuned, itself."""
    settings = config.masks.model(model)
    torch.set_num_threads(settings.threads)
    device = best_device()
    checkpoint = Checkpoint(out, f"{settings_of_training(config, model)} {device} {json.dumps(package_versions())}")
    pairs, held_out = read_pairs(*training), read_pairs(*validation)
    trainer = Trainer(model, recipe_of(config, model), pairs, training_seed(config), device)
    rows: list[dict[str, float]] = []
    saved = checkpoint.load()
    if saved is not None:
        trainer.resume(saved)
        rows = saved["rows"]
    stops = np.unique(np.linspace(0, trainer.recipe.steps, settings.checkpoints + 1).round().astype(int))[1:]
    last = time.monotonic()
    with tqdm(total=trainer.recipe.steps, initial=trainer.step, desc=model, unit="step", disable=None) as bar:
        while not trainer.finished:
            bar.set_postfix(loss=f"{trainer.advance():.3f}", refresh=False)
            bar.update()
            if trainer.step in stops:
                rows.append(_row(trainer, rows, held_out))
                bar.write(_told(model, rows[-1], trainer.recipe.steps), file=sys.stderr)
            if trainer.step in stops or time.monotonic() - last > SAVED_EVERY:
                checkpoint.save({**trainer.state(), "rows": rows})
                last = time.monotonic()
    trained = MaskPredictor(model, trainer.model, device=device)
    save_tuned(trained, held_out, predictor, config)
    write_table("mask_curves", pd.DataFrame(rows).assign(model=model), out, config)
    checkpoint.forget()


def write_difference(config: Config, validation: Sequence[Path], predictor: Path) -> None:
    """The image difference, of which only the rule is tuned."""
    save_tuned(MaskPredictor(UNTRAINED, None), read_pairs(*validation), predictor, config)


def save_tuned(predictor: MaskPredictor, held_out: Pairs, path: Path, config: Config) -> None:
    """Choose the decision rule on pairs that are neither trained on nor tested on, and save."""
    predictor.rule = tune(predictor.probabilities(held_out.pictures), held_out.outcome)
    predictor.save(path, provenance(config))


def gather_curves(parts: Sequence[Path], out: Path, config: Config) -> None:
    """Put the curves of all models together. Raises TableError if one is there twice."""
    frame = pd.concat([read_table("mask_curves", part) for part in parts], ignore_index=True)
    if frame.duplicated(["model", "step"]).any():
        raise TableError(f"{out}: a model's curve is there twice; give each part once")
    write_table("mask_curves", frame, out, config)


def _told(model: ModelName, row: dict[str, float], steps: int) -> str:
    """A line for the log."""
    return (
        f"{model}: step {row['step']:,} of {steps:,}, loss {row['loss']:.3f}; validation: accuracy {row['accuracy']:.3f}, mean IoU {row['iou']:.3f}"
    )


def _row(trainer: Trainer, rows: list[dict[str, float]], held_out: Pairs) -> dict[str, float]:
    """How far training has got, on pairs that it does not show, at first sight."""
    before = rows[-1]["step"] if rows else 0
    found = MaskPredictor(trainer.name, trainer.model, device=trainer.device).probabilities(held_out.pictures, again=False)
    moved = held_out.outcome == MOVED
    iou = intersection_over_union(found[moved], held_out.masks[moved])
    return dict(
        step=trainer.step,
        visits=trainer.step * trainer.recipe.batch_size,
        learning_rate=learning_rate(trainer.recipe, trainer.step - 1),
        loss=float(np.mean(trainer.losses[int(before) :])),
        accuracy=float((outcomes(found, Rule()) == held_out.outcome).mean()),
        iou=float(np.nanmean(np.nanmean(iou, axis=1))),
    )
