"""Models that learn to find what changed (paper, section IV-A, "Architecture and training")."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ...config import Config
from ...declarations import Shards, TrainingOutput, model
from ..builders import trained_models, training_settings

if TYPE_CHECKING:
    from ....change_detection.pair_files import Pairs
    from ....change_detection.training.mask_trainer import MaskTrainer


@model(
    title="Models that find what changed, without a view classifier",
    path="data/mask_training/{run}.predictor",
    curve="mask_curves",
    inputs=["mask_pairs/training", "mask_pairs/validation"],
    shards=Shards(runs=trained_models, settings=training_settings),
)
def mask_training(
    training: list[Path],
    validation: list[Path],
    config: Config,
    name: str,
    output: TrainingOutput,
) -> None:
    """Train a model, or resume where training was killed; write the model and its curve."""
    import torch
    from tqdm import tqdm

    from ....change_detection.pair_files import read_pairs
    from ....change_detection.predictor import MaskPredictor, best_device
    from ....change_detection.training.mask_trainer import MaskTrainer
    from ....storage.checkpoints import Checkpoint
    from ....storage.provenance import package_versions
    from ..builders import optimizer_settings, training_seed

    settings = config.masks.model(name)  # type: ignore[arg-type]  # checked by the runner
    torch.set_num_threads(settings.threads)
    device = best_device()
    versions = json.dumps(package_versions())
    checkpoint = Checkpoint(output.curve, f"{output.settings_digest} {device} {versions}")
    pairs, held_out = read_pairs(*training), read_pairs(*validation)
    trainer = MaskTrainer(name, optimizer_settings(settings), pairs, training_seed(config), device)
    steps = trainer.settings.steps
    evaluations = np.unique(np.linspace(0, steps, settings.checkpoints + 1).round().astype(int))[1:]

    def evaluate(rows: list[dict[str, float]]) -> dict[str, float]:
        row = evaluate_on_validation(trainer, rows, held_out)
        tqdm.write(
            f"{name}: step {row['step']:,} of {steps:,}, loss {row['loss']:.3f}; "
            f"validation: accuracy {row['accuracy']:.3f}, mean IoU {row['iou']:.3f}",
            file=sys.stderr,
        )
        return row

    rows = trainer.fit(checkpoint, name, evaluations.tolist(), evaluate)
    predictor = MaskPredictor(name, trainer.model, device=device)
    predictor.save(output.model, dict(output.metadata))
    output.write_curve(pd.DataFrame(rows).assign(model=name))
    checkpoint.remove()


def evaluate_on_validation(
    trainer: MaskTrainer, rows: list[dict[str, float]], held_out: Pairs
) -> dict[str, float]:
    """A row of the curve: the model on pairs that it is not trained on, without augmentation.

    Parameters
    ----------
    trainer : MaskTrainer
    rows : list of dict
        Rows so far.
    held_out : Pairs
    """
    from ....change_detection.decision import DecisionThresholds, accuracy_and_iou
    from ....change_detection.predictor import MaskPredictor
    from ....change_detection.training.trainer import get_lr

    previous = rows[-1]["step"] if rows else 0
    predictor = MaskPredictor(trainer.name, trainer.model, device=trainer.device)
    probabilities = predictor.predict_proba(held_out.pictures, tta=False)
    accuracy, iou = accuracy_and_iou(
        probabilities, held_out.outcome, held_out.masks, DecisionThresholds()
    )
    return dict(
        step=trainer.step,
        samples=trainer.step * trainer.settings.batch_size,
        learning_rate=get_lr(trainer.settings, trainer.step - 1),
        loss=float(np.mean(trainer.losses[int(previous) :])),
        accuracy=accuracy,
        iou=iou,
    )
