"""What the mask predictor says of every SC-experiment in the training apartment and of its alternatives (paper, section IV-A).

All experiments as they come, through the camera that was trained with; none is left out to make outcomes equally frequent.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from ....change_detection.decision import MASK, outcomes
from ....change_detection.outcome import OUTCOMES
from ....change_detection.predictor import MaskPredictor, load_predictor
from ....change_detection.simulated.object_experiments import COMPARISONS, KINDS
from ....storage.arrays import read_arrays, unpack
from ....storage.batches import write_in_batches
from ...config import Config
from ..data.mask_tuples import CONTENT
from .mask_comparisons import BETTER

TABLE = "mask_alternatives"
BATCH = 1  # household; with RAFT some 20 seconds


def write_alternatives(config: Config, predictor: Path, tuples: Sequence[Path], out: Path) -> None:
    """A row per experiment and comparison, resuming from finished batches; `tuples`: the files of the run as-trained in order."""
    loaded, per_job = load_predictor(predictor, BETTER), config.masks.tests.experiments_per_job

    def compute(start: int, stop: int) -> pd.DataFrame:
        return pd.concat(
            [_looked_at(loaded, tuples[i], i, per_job) for i in range(start, stop)],
            ignore_index=True,
        )

    write_in_batches(
        TABLE, compute, 0, len(tuples), out, config, str(per_job), BATCH, [predictor, *tuples]
    )


def _looked_at(predictor: MaskPredictor, path: Path, household: int, per_job: int) -> pd.DataFrame:
    """All rows of a file."""
    arrays, _ = read_arrays(path, CONTENT)
    pictures, truth = arrays["pictures"][:, 0], arrays["outcome"][:, 0]
    masks = unpack(arrays["masks"][:, 0], pictures.shape[-2])
    frames = []
    for k, comparison in enumerate(COMPARISONS):
        found = predictor.probabilities(pictures[:, k])
        predicted = found > MASK
        overlap = (predicted & masks[:, k]).sum((1, 2, 3)) / np.maximum(
            1, (predicted | masks[:, k]).sum((1, 2, 3))
        )
        columns = dict(
            household=household,
            experiment=household * per_job + np.arange(len(truth)),
            kind=[KINDS[q] for q in arrays["kind"]],
            comparison=comparison,
            outcome_true=[OUTCOMES[o] for o in truth[:, k]],
            outcome_predicted=[OUTCOMES[o] for o in outcomes(found, predictor.rule)],
            overlap=overlap,
            touched=arrays["touched_fixed"],
            touched_first=arrays["touched_fixed_first"],
        )
        frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True)
