"""Every model on every test tuple: the outcome, and the overlap of its masks with the true ones (paper, section IV-A, "Evaluation")."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ....change_detection.decision import MASK, intersection_over_union, outcomes
from ....change_detection.outcome import MOVED, OUTCOMES
from ....change_detection.predictor import MaskPredictor, load_predictor
from ....change_detection.simulated.object_experiments import KINDS
from ....storage.arrays import read_arrays, unpack
from ....storage.batches import write_in_batches
from ....storage.tables import read_table, write_table
from ...config import Config
from ..builders import tuple_runs
from ..data.mask_tuples import CONTENT

BATCH = 2  # households; with RAFT some 20 seconds


def score(
    predictor: MaskPredictor,
    test_set: str,
    pictures: np.ndarray,
    masks: np.ndarray,
    truth: np.ndarray,
) -> pd.DataFrame:
    """A row per tuple, columns of the table mask_scores from test_set on but for household, experiment and kind.

    Parameters
    ----------
    pictures : uint8 (n, 2, h, w, 3)
    masks : bool (n, 2, h, w)
    truth : int (n,)
        Indices into OUTCOMES.
    """
    found = predictor.probabilities(pictures)
    predicted = found > MASK
    moved = truth == MOVED
    iou = np.full((len(truth), 2), np.nan)
    iou[moved] = intersection_over_union(found[moved], masks[moved])
    return pd.DataFrame(
        dict(
            test_set=test_set,
            outcome_true=[OUTCOMES[k] for k in truth],
            outcome_predicted=[OUTCOMES[k] for k in outcomes(found, predictor.rule)],
            iou_1=iou[:, 0],
            iou_2=iou[:, 1],
            intersection=(predicted & masks).sum((1, 2, 3)),
            union=(predicted | masks).sum((1, 2, 3)),
            mask=masks.sum((1, 2, 3)),
        )
    )


def first_of_each(outcome: Sequence[np.ndarray], n: int) -> list[np.ndarray]:
    """Which tuples of a test set count, the first `n` of each outcome: of each file's outcomes, int (m,), the places int (k,) of those that do."""
    chosen, left = [], np.full(len(OUTCOMES), n)
    for truth in outcome:
        chosen.append(
            np.sort(
                np.concatenate([np.nonzero(truth == o)[0][: left[o]] for o in range(len(OUTCOMES))])
            )
        )
        left -= np.bincount(truth[chosen[-1]], minlength=len(OUTCOMES))
    return chosen


def write_model_scores(
    config: Config, predictor: Path, model: str, tuples: Mapping[str, Sequence[Path]], out: Path
) -> None:
    """Score a model on the first tuples of each outcome in every test set, resuming from finished batches; `tuples`: run -> its parts in order."""
    loaded, n, per_job = (
        load_predictor(predictor, model),
        config.masks.tests.tuples,
        config.masks.tests.experiments_per_job,
    )
    units: list[tuple[Path, int, dict[str, np.ndarray]]] = []
    """File, number of the household, and which of its tuples each test set takes."""
    for run in tuple_runs(config).values():
        truths = [read_arrays(path, CONTENT)[0]["outcome"][:, :, 0] for path in tuples[run.name]]
        chosen = {
            name: first_of_each([truth[:, k] for truth in truths], n)
            for k, name in enumerate(run.sets)
        }
        units += [
            (path, i, {name: places[i] for name, places in chosen.items()})
            for i, path in enumerate(tuples[run.name])
        ]

    def compute(start: int, stop: int) -> pd.DataFrame:
        return pd.concat(
            [_scored(loaded, *unit, per_job).assign(model=model) for unit in units[start:stop]],
            ignore_index=True,
        )

    sources = [predictor, *(path for path, *_ in units)]
    write_in_batches(
        "mask_scores", compute, 0, len(units), out, config, f"{model} {n}", BATCH, sources
    )


def _scored(
    predictor: MaskPredictor,
    path: Path,
    household: int,
    chosen: Mapping[str, np.ndarray],
    per_job: int,
) -> pd.DataFrame:
    """Rows of a file's chosen tuples, but for the model."""
    arrays, _ = read_arrays(path, CONTENT)
    frames = []
    for k, (name, places) in enumerate(chosen.items()):
        pictures = arrays["pictures"][places, k, 0]
        masks = unpack(arrays["masks"][places, k, 0], pictures.shape[3])
        rows = score(predictor, name, pictures, masks, arrays["outcome"][places, k, 0])
        kinds = [KINDS[q] for q in arrays["kind"][places]]
        frames.append(
            rows.assign(household=household, experiment=household * per_job + places, kind=kinds)
        )
    return pd.concat(frames, ignore_index=True)


def gather_scores(parts: Sequence[Path], out: Path, config: Config) -> None:
    """Put the models' scores together, in the order given."""
    write_table(
        "mask_scores",
        pd.concat([read_table("mask_scores", part) for part in parts], ignore_index=True),
        out,
        config,
    )
