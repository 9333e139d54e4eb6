"""Every model on every test tuple: the outcome, and the overlap of its masks with the true ones
(paper, section IV-A, "Evaluation")."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ....storage.columns import FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shards, table
from ..builders import MODELS, tuple_runs
from ..columns import HOUSEHOLD, MODEL, OUTCOME_TRUE, TEST_SET

if TYPE_CHECKING:
    from ....change_detection.predictor import MaskPredictor

BATCH = 2
"""Files of tuples in a batch; with RAFT about 20 seconds."""


def score(
    predictor: MaskPredictor,
    test_set: str,
    pictures: np.ndarray,
    masks: np.ndarray,
    truth: np.ndarray,
) -> pd.DataFrame:
    """Compare predictions with the truth, a row per tuple.

    Parameters
    ----------
    predictor : MaskPredictor
    test_set : str
    pictures : uint8 (n, 2, h, w, 3)
    masks : bool (n, 2, h, w)
    truth : int (n,)
        Indices into OUTCOMES.

    Returns
    -------
    DataFrame
        Columns of mask_scores apart from model, household, experiment and kind.
    """
    from ....change_detection.decision import (
        MASK_THRESHOLD,
        classify_outcomes,
        intersection_over_union,
    )
    from ....change_detection.outcome import MOVED, OUTCOMES

    probabilities = predictor.predict_proba(pictures)
    predicted = probabilities > MASK_THRESHOLD
    moved = truth == MOVED
    iou = np.full((len(truth), 2), np.nan)
    iou[moved] = intersection_over_union(probabilities[moved], masks[moved])
    return pd.DataFrame(
        dict(
            test_set=test_set,
            outcome_true=[OUTCOMES[k] for k in truth],
            outcome_predicted=[
                OUTCOMES[k] for k in classify_outcomes(probabilities, predictor.thresholds)
            ],
            iou_1=iou[:, 0],
            iou_2=iou[:, 1],
            intersection=(predicted & masks).sum((1, 2, 3)),
            union=(predicted | masks).sum((1, 2, 3)),
            mask=masks.sum((1, 2, 3)),
        )
    )


def first_of_each_outcome(outcomes: Sequence[np.ndarray], n: int) -> list[np.ndarray]:
    """Choose the first `n` tuples of each outcome over several files.

    Parameters
    ----------
    outcomes : sequence of int (m,)
        Outcomes of the tuples of each file, as indices into OUTCOMES.
    n : int

    Returns
    -------
    list of int (k,)
        Rows of each file that are chosen, ascending.
    """
    from ....change_detection.outcome import OUTCOMES

    chosen, left = [], np.full(len(OUTCOMES), n)
    for truth in outcomes:
        rows = [np.nonzero(truth == o)[0][: left[o]] for o in range(len(OUTCOMES))]
        chosen.append(np.sort(np.concatenate(rows)))
        left -= np.bincount(truth[chosen[-1]], minlength=len(OUTCOMES))
    return chosen


def _expected(config: Config, models: Sequence[str]) -> Expected:
    sets = [name for run in tuple_runs(config).values() for name in run.sets]
    rows: dict[tuple, int | None] = {(model, name): None for model in models for name in sets}
    return Expected(("model", "test_set"), rows)


@table(
    title="Predictions of every model on the test tuples",
    columns=(
        MODEL,
        TEST_SET,
        HOUSEHOLD,
        Column("experiment", INT, "1", "number of the SC-experiment in its run", key=True),
        Column(
            "kind", TEXT, "",
            "random: a sequence and a permutation; left-right: left then right, against right then "
            "left",
        ),
        OUTCOME_TRUE,
        Column("outcome_predicted", TEXT, "", "the same, as the model predicts"),
        Column(
            "iou_1", FLOAT, "1",
            "intersection over union of the first mask where something moved; missing if both are "
            "empty", nullable=True, low=0, high=1,
        ),
        Column("iou_2", FLOAT, "1", "of the second mask", nullable=True, low=0, high=1),
        Column(
            "intersection", INT, "pixels", "of predicted and true masks, summed over both views"
        ),
        Column("union", INT, "pixels", "of predicted and true masks, summed over both views"),
        Column("mask", INT, "pixels", "true masks, summed over both views"),
    ),
    inputs=lambda config, run: [f"mask_predictor/{run}",
                                *(f"mask_tuples/{name}" for name in tuple_runs(config))],
    shards=Shards(
        runs=lambda config: dict.fromkeys(MODELS, 1),
        settings=lambda config, run: config.masks.tests.tuples,
    ),
    expected=lambda config: _expected(config, MODELS),
    expected_shard=lambda config, shard: _expected(config, (shard.run,)),
)  # fmt: skip
def mask_scores(predictor: Path, *arguments) -> Batched:
    """Score a model on the first tuples of each outcome in every test set.

    `arguments` are the files of tuples of each run, the configuration, and the model's name.
    """
    from ....change_detection.predictor import load_predictor
    from ....storage.arrays import read_arrays

    *tuples, config, model = arguments
    loaded = load_predictor(predictor, model)
    n = config.masks.tests.tuples
    files: list[tuple[Path, dict[str, np.ndarray]]] = []  # file, and rows that each test set takes
    for run, paths in zip(tuple_runs(config).values(), tuples, strict=True):
        truths = [read_arrays(path, "mask_tuples")[0]["outcome"][:, :, 0] for path in paths]
        chosen = {
            name: first_of_each_outcome([truth[:, k] for truth in truths], n)
            for k, name in enumerate(run.sets)
        }
        files += [
            (path, {name: rows[i] for name, rows in chosen.items()}) for i, path in enumerate(paths)
        ]

    def compute(start: int, stop: int) -> pd.DataFrame:
        frames = [_score_file(loaded, *file) for file in files[start:stop]]
        return pd.concat(frames, ignore_index=True).assign(model=model)

    return Batched(compute, BATCH, units=len(files))


def _score_file(
    predictor: MaskPredictor, path: Path, chosen: dict[str, np.ndarray]
) -> pd.DataFrame:
    """Scores of the chosen rows of a file of tuples, for every test set."""
    from ....change_detection.simulated.object_experiments import KINDS
    from ....storage.arrays import read_arrays, unpack_masks

    arrays, _ = read_arrays(path, "mask_tuples")
    frames = []
    for k, (name, rows) in enumerate(chosen.items()):
        pictures = arrays["pictures"][rows, k, 0]
        masks = unpack_masks(arrays["masks"][rows, k, 0], pictures.shape[3])
        frames.append(
            score(predictor, name, pictures, masks, arrays["outcome"][rows, k, 0]).assign(
                household=arrays["scene"][rows],
                experiment=arrays["experiment"][rows],
                kind=[KINDS[q] for q in arrays["kind"][rows]],
            )
        )
    return pd.concat(frames, ignore_index=True)
