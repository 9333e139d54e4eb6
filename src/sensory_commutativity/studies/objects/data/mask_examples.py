"""Pictures for people: pairs of the data set, and SC-experiments with what was predicted, taken by a rule and not by looks.

Of each test set the tuples in which something moved are shown at the tenth, fiftieth and ninetieth percentile of the overlap, and the first tuple
of each other outcome.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ....change_detection.outcome import OUTCOMES
from ....change_detection.pair_files import read_pairs
from ....change_detection.predictor import load_predictor
from ....storage.arrays import pack, read_arrays, unpack, write_arrays
from ....storage.provenance import provenance
from ....storage.tables import read_table
from ...config import Config
from ..builders import tuple_runs
from ..tables.mask_comparisons import BETTER
from ..tables.mask_summary import ious
from .mask_tuples import CONTENT

EXAMPLES = "examples"
PAIRS = 3
"""Pairs of each outcome that are shown of the data set: the first."""
PERCENTILES = (0.1, 0.5, 0.9)


def chosen_examples(scores: pd.DataFrame) -> list[tuple[int, float]]:
    """(experiment, overlap) of the tuples to show; `scores`: the rows of mask_scores of one model on one test set."""
    moved = (
        scores[scores["outcome_true"] == "moved"]
        .assign(iou=ious(scores)[scores["outcome_true"] == "moved"])
        .dropna(subset="iou")
    )
    ranked = moved.sort_values(["iou", "experiment"])
    places = (
        [round(percentile * (len(ranked) - 1)) for percentile in PERCENTILES] if len(ranked) else []
    )
    shown = [(int(ranked["experiment"].iloc[k]), float(ranked["iou"].iloc[k])) for k in places]
    for outcome in ("identical", "different"):
        shown += [
            (int(k), float("nan"))
            for k in scores.loc[scores["outcome_true"] == outcome, "experiment"].head(1)
        ]
    return shown


def write_examples(
    config: Config,
    training: Sequence[Path],
    tuples: Mapping[str, Sequence[Path]],
    predictor: Path,
    mask_scores: Path,
    out: Path,
) -> None:
    """Write pictures, masks, probabilities and outcomes as arrays; `tuples`: run -> its parts in order."""
    pairs, loaded = read_pairs(training[0]), load_predictor(predictor, BETTER)
    shown = np.concatenate(
        [np.nonzero(pairs.outcome == k)[0][:PAIRS] for k in range(len(OUTCOMES))]
    )
    scores = read_table("mask_scores", mask_scores)
    scores = scores[scores["model"] == BETTER]
    per_job = config.masks.tests.experiments_per_job
    pictures, masks, truth, test_sets, overlaps, found = [], [], [], [], [], []
    for run in tuple_runs(config).values():
        for camera, test_set in enumerate(run.sets):
            for experiment, overlap in chosen_examples(scores[scores["test_set"] == test_set]):
                arrays, _ = read_arrays(tuples[run.name][experiment // per_job], CONTENT)
                k = experiment % per_job
                pictures.append(arrays["pictures"][k, camera, 0])
                masks.append(unpack(arrays["masks"][k, camera, 0], pictures[-1].shape[2]))
                truth.append(arrays["outcome"][k, camera, 0])
                test_sets.append(test_set)
                overlaps.append(overlap)
                found.append(loaded.predict(*pictures[-1]))
    arrays = dict(
        dataset_pictures=pairs.pictures[shown],
        dataset_masks=pack(pairs.masks[shown]),
        dataset_outcome=pairs.outcome[shown],
        pictures=np.stack(pictures),
        masks=pack(np.stack(masks)),
        probabilities=(np.stack([one.probabilities for one in found]) * 255)
        .round()
        .astype(np.uint8),
        outcome=np.array(truth, np.int8),
        predicted=np.array([OUTCOMES.index(one.outcome) for one in found], np.int8),
        overlap=np.array(overlaps),
    )
    write_arrays(out, EXAMPLES, arrays, {"test_sets": json.dumps(test_sets), **provenance(config)})
