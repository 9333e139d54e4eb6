"""Pictures for figures: pairs of the data set, and SC-experiments with predictions, chosen by a
rule and not by looks.

Of each test set these are the tuples in which something moved at the 10th, 50th and 90th percentile
of the overlap, and the first tuple of each other outcome.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...declarations import arrays
from ..builders import tuple_runs
from ..tables.mask_comparisons import REFERENCE_MODEL
from ..tables.mask_summary import mean_iou_per_tuple

PAIRS = 3
"""Pairs of each outcome that are shown of the data set: the first."""
PERCENTILES = (0.1, 0.5, 0.9)


def choose_examples(scores: pd.DataFrame) -> list[tuple[int, float]]:
    """(experiment, overlap) of the tuples to show.

    `scores` are the rows of mask_scores of one model on one test set.
    """
    moved = scores[scores["outcome_true"] == "moved"]
    moved = moved.assign(iou=mean_iou_per_tuple(moved)).dropna(subset="iou")
    ranked = moved.sort_values(["iou", "experiment"])
    ranks = [round(percentile * (len(ranked) - 1)) for percentile in PERCENTILES]
    examples = [
        (int(ranked["experiment"].iloc[k]), float(ranked["iou"].iloc[k]))
        for k in (ranks if len(ranked) else [])
    ]
    for outcome in ("identical", "different"):
        first = scores.loc[scores["outcome_true"] == outcome, "experiment"].head(1)
        examples += [(int(experiment), float("nan")) for experiment in first]
    return examples


@arrays(
    title="Example pictures with masks and predictions",
    inputs=lambda config, run: [
        "mask_pairs/training",
        *(f"mask_tuples/{name}" for name in tuple_runs(config)),
        f"mask_predictor/{REFERENCE_MODEL}",
        "mask_scores",
    ],
)
def mask_examples(training: list[Path], *arguments) -> tuple[dict[str, Any], dict[str, str]]:
    """Pictures, masks, probabilities and outcomes.

    `arguments` are the files of tuples of each run, the file of the predictor, the scores and the
    configuration.
    """
    from ....change_detection.outcome import OUTCOMES
    from ....change_detection.pair_files import read_pairs
    from ....change_detection.predictor import load_predictor
    from ....storage.arrays import pack_masks, unpack_masks

    *tuples, predictor, scores, config = arguments
    loaded = load_predictor(predictor, REFERENCE_MODEL)
    pairs = read_pairs(*training[:PAIRS])  # every file holds at least one pair of each outcome
    shown = np.concatenate(
        [np.nonzero(pairs.outcome == k)[0][:PAIRS] for k in range(len(OUTCOMES))]
    )
    scores = scores[scores["model"] == REFERENCE_MODEL]
    pictures, masks, truth, test_sets, overlaps, predictions = [], [], [], [], [], []
    for run, files in zip(tuple_runs(config).values(), tuples, strict=True):
        for camera, test_set in enumerate(run.sets):
            for experiment, overlap in choose_examples(scores[scores["test_set"] == test_set]):
                arrays, k = _find_experiment(files, experiment)
                pictures.append(arrays["pictures"][k, camera, 0])
                masks.append(unpack_masks(arrays["masks"][k, camera, 0], pictures[-1].shape[2]))
                truth.append(arrays["outcome"][k, camera, 0])
                test_sets.append(test_set)
                overlaps.append(overlap)
                predictions.append(loaded.predict(*pictures[-1]))
    probabilities = np.stack([prediction.probabilities for prediction in predictions])
    predicted = [OUTCOMES.index(prediction.outcome) for prediction in predictions]
    content = dict(
        dataset_pictures=pairs.pictures[shown],
        dataset_masks=pack_masks(pairs.masks[shown]),
        dataset_outcome=pairs.outcome[shown],
        pictures=np.stack(pictures),
        masks=pack_masks(np.stack(masks)),
        probabilities=(probabilities * 255).round().astype(np.uint8),
        outcome=np.array(truth, np.int8),
        predicted=np.array(predicted, np.int8),
        overlap=np.array(overlaps),
    )
    return content, {"test_sets": json.dumps(test_sets)}


def _find_experiment(files: list[Path], experiment: int) -> tuple[dict[str, np.ndarray], int]:
    """The arrays of the file that holds an experiment, and its row there."""
    from ....storage.arrays import read_arrays

    for path in files:
        arrays, _ = read_arrays(path, "mask_tuples")
        rows = np.nonzero(arrays["experiment"] == experiment)[0]
        if len(rows):
            return arrays, int(rows[0])
    raise LookupError(f"no file of tuples holds experiment {experiment}")
