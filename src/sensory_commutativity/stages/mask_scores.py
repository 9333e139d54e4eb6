"""Every model on every test tuple: the outcome, and the overlap of its masks with the true ones (paper, section IV-A, "Evaluation")."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ..config import Config
from ..masks.decision import MASK, intersection_over_union, outcomes
from ..masks.experiments import KINDS
from ..masks.from_config import tuple_runs
from ..masks.outcome import OUTCOMES
from ..masks.predictor import MaskPredictor, load_predictor
from ..masks.store import read_arrays, unpack
from ..progress import progress
from ..tables import read_table, write_table
from .mask_tuples import CONTENT

MOVED = OUTCOMES.index("moved")


def score(predictor: MaskPredictor, test_set: str, pictures: np.ndarray, masks: np.ndarray, truth: np.ndarray) -> pd.DataFrame:
    """A row per tuple, columns of the table mask_scores from test_set on but for household, experiment and kind.

    Parameters
    ----------
    pictures : uint8 (n, 2, h, w, 3)
    masks : bool (n, 2, h, w)
    truth : int (n,)
        Places in OUTCOMES.
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


def write_model_scores(config: Config, predictor: Path, model: str, tuples: Mapping[str, Sequence[Path]], out: Path) -> None:
    """Score a model on the first tuples of each outcome in every test set; `tuples`: run -> its parts in order."""
    loaded = load_predictor(predictor, model)
    rows = []
    for run in tuple_runs(config).values():
        taken = {name: np.zeros(len(OUTCOMES), int) for name in run.sets}
        before = 0
        for household, part in enumerate(progress(tuples[run.name], f"{model} {run.name}", "part")):
            arrays, _ = read_arrays(part, CONTENT)
            for k, name in enumerate(run.sets):
                truth = arrays["outcome"][:, k, 0]
                left = config.masks.tests.tuples - taken[name]
                chosen = np.sort(np.concatenate([np.nonzero(truth == o)[0][: left[o]] for o in range(len(OUTCOMES))]))
                taken[name] += np.bincount(truth[chosen], minlength=len(OUTCOMES))
                if not len(chosen):
                    continue
                pictures = arrays["pictures"][chosen, k, 0]
                scores = score(loaded, name, pictures, unpack(arrays["masks"][chosen, k, 0], pictures.shape[3]), truth[chosen])
                rows.append(
                    scores.assign(model=model, household=household, experiment=before + chosen, kind=[KINDS[q] for q in arrays["kind"][chosen]])
                )
            before += len(arrays["kind"])
    write_table("mask_scores", pd.concat(rows, ignore_index=True), out, config)


def gather_scores(parts: Sequence[Path], out: Path, config: Config) -> None:
    """Put the models' scores together, in the order given."""
    write_table("mask_scores", pd.concat([read_table("mask_scores", part) for part in parts], ignore_index=True), out, config)
