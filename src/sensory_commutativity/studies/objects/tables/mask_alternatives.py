"""What the mask predictor says of every SC-experiment in the training apartment, and of the two
alternatives to it (paper, section IV-A).

All experiments count, seen through the camera of the training; none is left out to make outcomes
equally frequent.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ....storage.columns import BOOL, FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Batched, Expected, table
from ..columns import COMPARISON, COMPARISONS, HOUSEHOLD, KIND, OUTCOME_TRUE
from .mask_comparisons import REFERENCE_MODEL

if TYPE_CHECKING:
    from ....change_detection.predictor import MaskPredictor


def _expected(config: Config) -> Expected:
    n = config.masks.tests.experiments
    return Expected(("comparison",), dict.fromkeys(((name,) for name in COMPARISONS), n))


@table(
    title="Predictions for SC-experiments and their alternatives",
    columns=(
        HOUSEHOLD,
        Column("experiment", INT, "1", "number of the SC-experiment in its run", key=True),
        KIND,
        COMPARISON,
        OUTCOME_TRUE,
        Column("outcome_predicted", TEXT, "", "the same, as RAFT predicts"),
        Column(
            "overlap", FLOAT, "1",
            "intersection over union of both masks together; 0 where both are empty", low=0, high=1,
        ),
        Column("touched", BOOL, "", "whether an immovable object was touched in either order"),
        Column(
            "touched_first", BOOL, "",
            "whether in the first; the way back of a return does not count",
        ),
    ),
    inputs=[f"mask_predictor/{REFERENCE_MODEL}", "mask_tuples/as-trained"],
    expected=_expected,
)  # fmt: skip
def mask_alternatives(predictor: Path, tuples: list[Path], config: Config) -> Batched:
    """A row per experiment and comparison."""
    from ....change_detection.predictor import load_predictor

    loaded = load_predictor(predictor, REFERENCE_MODEL)

    def compute(start: int, stop: int) -> pd.DataFrame:
        frames = [predict_comparisons(loaded, path) for path in tuples[start:stop]]
        return pd.concat(frames, ignore_index=True)

    return Batched(compute, size=1, units=len(tuples))


def predict_comparisons(predictor: MaskPredictor, path: Path) -> pd.DataFrame:
    """All rows of a file of tuples."""
    from ....change_detection.decision import MASK_THRESHOLD, classify_outcomes
    from ....change_detection.outcome import OUTCOMES
    from ....change_detection.simulated.object_experiments import KINDS
    from ....storage.arrays import read_arrays, unpack_masks

    arrays, _ = read_arrays(path, "mask_tuples")
    pictures, truth = arrays["pictures"][:, 0], arrays["outcome"][:, 0]
    masks = unpack_masks(arrays["masks"][:, 0], pictures.shape[-2])
    frames = []
    for k, comparison in enumerate(COMPARISONS):
        probabilities = predictor.predict_proba(pictures[:, k])
        predicted = probabilities > MASK_THRESHOLD
        intersection = (predicted & masks[:, k]).sum((1, 2, 3))
        union = (predicted | masks[:, k]).sum((1, 2, 3))
        predicted_outcomes = classify_outcomes(probabilities, predictor.thresholds)
        columns = dict(
            household=arrays["scene"],
            experiment=arrays["experiment"],
            kind=[KINDS[q] for q in arrays["kind"]],
            comparison=comparison,
            outcome_true=[OUTCOMES[o] for o in truth[:, k]],
            outcome_predicted=[OUTCOMES[o] for o in predicted_outcomes],
            overlap=intersection / np.maximum(1, union),
            touched=arrays["touched_fixed"],
            touched_first=arrays["touched_fixed_first"],
        )
        frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True)
