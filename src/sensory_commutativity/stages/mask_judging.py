"""Predictors as they are used: a trained model gets its judge of places and its decision rule."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import torch

from ..checkpoints import Checkpoint
from ..config import Config, ModelName
from ..masks.cycle import to_the_end
from ..masks.decision import tune
from ..masks.from_config import recipe_of_judge, settings_of_judging, training_seed
from ..masks.judging import JudgeTrainer
from ..masks.predictor import UNTRAINED, MaskPredictor, best_device, load_predictor
from ..masks.store import Pairs, read_pairs
from ..provenance import package_versions, provenance
from ..runs.checksums import sha256
from .mask_places import read_places
from .mask_training import quality


def write_judged(config: Config, model: ModelName, predictor: Path, places: Sequence[Path], validation: Sequence[Path], out: Path) -> None:
    """Train a judge, or go on with it where it was killed; write the predictor with it, tuned. A model that found no place gets no judge."""
    torch.set_num_threads(1)
    device = best_device()
    trained, seen = load_predictor(predictor, model, device), read_places(*places)
    sources = [sha256(path) for path in (predictor, *places)]
    checkpoint = Checkpoint(out, f"{settings_of_judging(config, model)} {sources} {device} {json.dumps(package_versions())}")
    if len(seen.empty):
        trainer = JudgeTrainer(seen, recipe_of_judge(config), training_seed(config), device)
        to_the_end(trainer, checkpoint, f"judge of {model}")
        trained = MaskPredictor(model, trained.model, device=device, judge=trainer.model)
    _save_tuned(trained, read_pairs(*validation), out, config)
    checkpoint.forget()


def write_difference(config: Config, validation: Sequence[Path], predictor: Path) -> None:
    """The image difference, of which only the rule is tuned."""
    _save_tuned(MaskPredictor(UNTRAINED, None), read_pairs(*validation), predictor, config)


def _save_tuned(predictor: MaskPredictor, held_out: Pairs, path: Path, config: Config) -> None:
    """Choose the decision rule on pairs that are neither trained on nor tested on, say how good it is on them, and save."""
    found = predictor.probabilities(held_out.pictures)
    predictor.rule = tune(found, held_out.outcome)
    accuracy, iou = quality(found, held_out, predictor.rule)
    print(f"{predictor.name}: validation: accuracy {accuracy:.3f}, mean IoU {iou:.3f}", file=sys.stderr)
    predictor.save(path, provenance(config))
