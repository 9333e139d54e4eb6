"""Predictors as they are used: a trained model with its view classifier and its decision
thresholds; and the image difference, of which only the thresholds are tuned."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...config import Config
from ...declarations import Shards, TrainingOutput, model
from ..builders import MODELS, trained_models

if TYPE_CHECKING:
    from ....change_detection.models.view_classifier import ViewClassifier
    from ....change_detection.pair_files import Pairs
    from ....change_detection.predictor import MaskPredictor
    from ....change_detection.training.view_classifier_trainer import Regions


def _inputs(config: Config, run: str | None) -> list[str]:
    if run in trained_models(config):
        return [f"mask_training/{run}", f"mask_regions/{run}", "mask_pairs/validation"]
    return ["mask_pairs/validation"]


@model(
    title="Mask predictors",
    path="models/masks/{run}.predictor",
    inputs=_inputs,
    shards=Shards(
        runs=lambda config: dict.fromkeys(MODELS, 1),
        settings=lambda config, run: config.masks.view_classifier,
    ),
)
def mask_predictor(*arguments) -> None:
    """Train the view classifier of a model, or resume, and write the predictor, tuned.

    `arguments` are the files of the trained model, of its regions and of the validation pairs (for
    the image difference the last alone), then the configuration, the name and a
    :class:`.TrainingOutput`.
    """
    import torch

    from ....change_detection.pair_files import read_pairs
    from ....change_detection.predictor import UNTRAINED, MaskPredictor

    *inputs, config, name, output = arguments
    torch.set_num_threads(1)
    held_out = read_pairs(*inputs[-1])
    if name == UNTRAINED:
        difference = MaskPredictor(UNTRAINED, None)
        probabilities = difference.predict_proba(held_out.pictures)
        _tune_and_save(difference, probabilities, held_out, output)
    else:
        _train_view_classifier(inputs[0], inputs[1], held_out, config, name, output)


def _train_view_classifier(
    model_file: Path, region_files: list[Path], held_out: Pairs, config: Config, name: str,
    output: TrainingOutput,
) -> None:  # fmt: skip
    """A classifier without regions to learn from, or one that harms, is left out."""
    from ....change_detection.predictor import best_device, load_predictor
    from ....change_detection.training.view_classifier_trainer import ViewClassifierTrainer
    from ....storage.checkpoints import Checkpoint
    from ....storage.hashing import sha256
    from ....storage.provenance import package_versions
    from ..builders import optimizer_settings, training_seed

    device = best_device()
    predictor, regions = load_predictor(model_file, name, device), read_regions(*region_files)
    sources = [sha256(path) for path in (model_file, *region_files)]
    settings = f"{output.settings_digest} {sources} {device} {json.dumps(package_versions())}"
    checkpoint = Checkpoint(output.model, settings)
    probabilities = predictor.predict_proba(held_out.pictures)
    if len(regions.empty):
        optimizer = optimizer_settings(config.masks.view_classifier)
        trainer = ViewClassifierTrainer(regions, optimizer, training_seed(config), device)
        trainer.fit(checkpoint, f"view classifier of {name}")
        probabilities = add_view_classifier(
            predictor, trainer.model.eval(), probabilities, held_out
        )
    _tune_and_save(predictor, probabilities, held_out, output)
    checkpoint.remove()


def read_regions(*paths: Path) -> Regions:
    """Read what the arrays mask_regions hold, all files as one. Raises ArrayFileError."""
    from ....change_detection.training.view_classifier_trainer import Regions
    from ....storage.arrays import read_arrays

    parts = [read_arrays(path, "mask_regions")[0] for path in paths]
    return Regions(*(np.concatenate([part[name] for part in parts]) for name in Regions._fields))


def add_view_classifier(
    predictor: MaskPredictor, classifier: ViewClassifier, probabilities: np.ndarray, held_out: Pairs
) -> np.ndarray:
    """Add a view classifier to a predictor, unless it lowers the IoU on the validation pairs.

    A classifier that was trained too little lowers it.

    Parameters
    ----------
    predictor : MaskPredictor
        Without a view classifier; changed in place.
    classifier : ViewClassifier
    probabilities : float (n, 2, h, w)
        What the predictor says of the pairs without it.
    held_out : Pairs
        Not trained on.

    Returns
    -------
    float (n, 2, h, w)
        What the predictor now says of the pairs.
    """
    from ....change_detection.decision import DecisionThresholds, accuracy_and_iou
    from ....change_detection.models.view_classifier import refine_masks

    refined = refine_masks(classifier, probabilities, held_out.pictures)
    before, after = (
        accuracy_and_iou(maps, held_out.outcome, held_out.masks, DecisionThresholds())[1]
        for maps in (probabilities, refined)
    )
    worse = after < before
    note = ", which is left out; show it more regions (masks.view_classifier.samples)"
    print(
        f"{predictor.name}: validation: mean IoU {before:.3f} alone, "
        f"{after:.3f} with its view classifier{note if worse else ''}",
        file=sys.stderr,
    )
    if worse:
        return probabilities
    predictor.view_classifier = classifier
    return refined


def _tune_and_save(
    predictor: MaskPredictor, probabilities: np.ndarray, held_out: Pairs, output: TrainingOutput
) -> None:
    """Tune the decision thresholds on pairs neither trained on nor tested on, and save."""
    from ....change_detection.decision import accuracy_and_iou, tune_thresholds

    predictor.thresholds = tune_thresholds(probabilities, held_out.outcome)
    accuracy, iou = accuracy_and_iou(
        probabilities, held_out.outcome, held_out.masks, predictor.thresholds
    )
    print(
        f"{predictor.name}: validation: accuracy {accuracy:.3f}, mean IoU {iou:.3f}",
        file=sys.stderr,
    )
    predictor.save(output.model, dict(output.metadata))
