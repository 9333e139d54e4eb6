"""Predictors as they are used: a trained model gets its judge of places and its decision rule."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch

from ....change_detection.decision import DecisionThresholds, quality, tune
from ....change_detection.models.view_classifier import ViewClassifier, refine_masks
from ....change_detection.pair_files import Pairs, read_pairs
from ....change_detection.predictor import UNTRAINED, MaskPredictor, best_device, load_predictor
from ....change_detection.training.trainer import fit
from ....change_detection.training.view_classifier_trainer import ViewClassifierTrainer
from ....runs.checksums import sha256
from ....storage.checkpoints import Checkpoint
from ....storage.provenance import package_versions, provenance
from ...config import Config
from ..builders import recipe_of_judge, settings_of_judging, training_seed
from ..config import ModelName
from ..data.mask_places import read_places


def write_judged(
    config: Config,
    model: ModelName,
    predictor: Path,
    places: Sequence[Path],
    validation: Sequence[Path],
    out: Path,
) -> None:
    """Train a judge, or go on with it where it was killed, and write the predictor with it, tuned.

    A judge that has no place to learn from, or that harms (:func:`given_a_judge`), is left out.
    """
    torch.set_num_threads(1)
    device = best_device()
    trained, seen = load_predictor(predictor, model, device), read_places(*places)
    sources = [sha256(path) for path in (predictor, *places)]
    checkpoint = Checkpoint(
        out,
        f"{settings_of_judging(config, model)} {sources} {device} {json.dumps(package_versions())}",
    )
    held_out = read_pairs(*validation)
    found = trained.probabilities(held_out.pictures)
    if len(seen.empty):
        trainer = ViewClassifierTrainer(
            seen, recipe_of_judge(config), training_seed(config), device
        )
        fit(trainer, checkpoint, f"judge of {model}")
        found = given_a_judge(trained, trainer.model.eval(), found, held_out)
    _save_tuned(trained, found, held_out, out, config)
    checkpoint.forget()


def write_difference(config: Config, validation: Sequence[Path], predictor: Path) -> None:
    """The image difference, of which only the rule is tuned."""
    held_out, difference = read_pairs(*validation), MaskPredictor(UNTRAINED, None)
    _save_tuned(
        difference, difference.probabilities(held_out.pictures), held_out, predictor, config
    )


def given_a_judge(
    predictor: MaskPredictor, judge: ViewClassifier, found: np.ndarray, held_out: Pairs
) -> np.ndarray:
    """Give a predictor its judge, unless masks of pairs that are not trained on are worse with it, as with one that was shown too little.

    Parameters
    ----------
    predictor : MaskPredictor
        Without a judge; changed in place.
    judge : ViewClassifier
    found : float (n, 2, h, w)
        What the predictor says of the pairs alone.
    held_out : Pairs

    Returns
    -------
    float (n, 2, h, w)
        What it now says of them.
    """
    mended = refine_masks(
        judge, found, held_out.pictures
    )  # where nothing is in doubt there is no place, and nothing changes
    alone, both = (
        quality(maps, held_out.outcome, held_out.masks, DecisionThresholds())[1]
        for maps in (found, mended)
    )
    worse = both < alone
    says = f"{predictor.name}: validation: mean IoU {alone:.3f} alone, {both:.3f} with its judge"
    print(
        says + (", which is left out; show it more places (masks.view_classifier.samples)" if worse else ""),
        file=sys.stderr,
    )
    if worse:
        return found
    predictor.view_classifier = judge
    return mended


def _save_tuned(
    predictor: MaskPredictor, found: np.ndarray, held_out: Pairs, path: Path, config: Config
) -> None:
    """Choose the decision rule on pairs that are neither trained on nor tested on, of which `found` is said; say how good it is on them, and save."""
    predictor.rule = tune(found, held_out.outcome)
    accuracy, iou = quality(found, held_out.outcome, held_out.masks, predictor.rule)
    print(
        f"{predictor.name}: validation: accuracy {accuracy:.3f}, mean IoU {iou:.3f}",
        file=sys.stderr,
    )
    predictor.save(path, provenance(config))
