"""Made-up pairs and scores."""

from __future__ import annotations

import numpy as np
import pandas as pd

from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.studies.objects.tables.mask_scores import mask_scores

IDENTICAL, DIFFERENT, MOVED = range(3)
ALL = dict.fromkeys(OUTCOMES, 20)


def make_scores(
    model: str, test_set: str, correct: dict[str, int], n: int = 20, iou: float = 0.9
) -> pd.DataFrame:
    """Rows of mask_scores: `n` tuples of each outcome, two in each cluttered scene.

    The first `correct` of each outcome are predicted correctly, the others as the next outcome.
    Every second pair of masks has only one that is not empty.
    """
    rows = []
    for k, outcome in enumerate(OUTCOMES):
        for i in range(n):
            predicted = outcome if i < correct[outcome] else OUTCOMES[(k + 1) % 3]
            ious = (iou - 0.01 * (i % 3), iou if i % 2 else np.nan)
            ious = ious if outcome == "moved" else (np.nan, np.nan)
            rows.append((model, test_set, i // 2, k * n + i, "random", outcome, predicted, *ious,
                         90, 100, 95))  # fmt: skip
    return pd.DataFrame(rows, columns=mask_scores.column_names)
