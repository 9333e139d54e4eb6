"""Regions that a trained model finds changed in training pairs, for its judge to learn from, a file per file of pairs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....change_detection.outcome import MOVED
from ....change_detection.pair_files import read_pairs
from ....change_detection.predictor import best_device, load_predictor
from ....change_detection.training.view_classifier_trainer import Regions, labelled_regions
from ....storage.arrays import read_arrays, write_arrays
from ....storage.provenance import provenance
from ...config import Config
from ..config import ModelName


def write_mask_places(
    config: Config, model: ModelName, predictor: Path, pairs: Path, out: Path
) -> None:
    """The places of the first pairs of a file in which something moved."""
    told = read_pairs(pairs)
    chosen = np.nonzero(told.outcome == MOVED)[0][: config.masks.view_classifier.pairs]
    places = labelled_regions(
        load_predictor(predictor, model, best_device()), told.pictures[chosen], told.masks[chosen]
    )
    write_arrays(out, "places", places._asdict(), provenance(config))


def read_places(*paths: Path) -> Regions:
    """Read what :func:`write_mask_places` wrote, all files as one. Raises StoreError."""
    parts = [read_arrays(path, "places")[0] for path in paths]
    return Regions(*(np.concatenate([part[name] for part in parts]) for name in Regions._fields))
