"""Regions that a trained model takes as changed in training pairs, for its view classifier to learn
from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...config import Config
from ...declarations import Shard, Shards, arrays
from ..builders import count_pair_scenes, trained_models


@arrays(
    title="Changed regions for training the view classifiers",
    inputs=lambda config, run: [f"mask_training/{run}", "mask_pairs/training:{part}"],
    shards=Shards(
        runs=lambda config: dict.fromkeys(
            trained_models(config), count_pair_scenes(config)["training"]
        ),
        settings=lambda config, run: config.masks.view_classifier.pairs,
        per_shard=lambda config: config.masks.data.scenes_per_job,
    ),
)
def mask_regions(
    predictor: Path, pairs: list[Path], config: Config, shard: Shard
) -> tuple[dict[str, Any], dict[str, str]]:
    """Regions in the first pairs of each scene in which something moved."""
    from ....change_detection.outcome import MOVED
    from ....change_detection.pair_files import read_pairs
    from ....change_detection.predictor import best_device, load_predictor
    from ....change_detection.training.view_classifier_trainer import label_regions

    training = read_pairs(*pairs)
    moved = training.outcome == MOVED
    limit = config.masks.view_classifier.pairs
    chosen = np.concatenate(
        [np.nonzero(moved & (training.scene == k))[0][:limit] for k in np.unique(training.scene)]
    )
    loaded = load_predictor(predictor, shard.run, best_device())
    regions = label_regions(loaded, training.pictures[chosen], training.masks[chosen])
    return regions._asdict(), {}
