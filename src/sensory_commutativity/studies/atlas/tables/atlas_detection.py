"""Does the distance of two orders tell that an object ended elsewhere?"""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import ENVIRONMENT

RESAMPLES = 1000
"""Bootstrap resamples of the starts. Chosen."""


@table(
    title="Distances where an object ended elsewhere",
    columns=(
        ENVIRONMENT,
        Column("n", INT, "1", "experiments"),
        Column("events", INT, "1", "experiments in which an object ended elsewhere"),
        Column("auc", FLOAT, "1", "area under the ROC curve of the distance for such an event"),
        *INTERVAL,
    ),
    inputs=["atlas_experiments"],
    expected=lambda config: Expected((), {}),  # no row where nothing moved
)
def atlas_detection(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The area under the ROC curve, where there are events; intervals by resampling starts."""
    import numpy as np

    from ....seeding import generator
    from ....statistics.clusters import area_under_roc_curve

    rows = []
    for name, of_one in experiments.dropna(subset="moved").groupby("environment", sort=False):
        moved = of_one["moved"].to_numpy() > 0
        if not 0 < moved.sum() < len(moved):
            continue
        distance, starts = of_one["distance"].to_numpy(), of_one["experiment"].to_numpy()
        members = [np.flatnonzero(starts == start) for start in np.unique(starts)]
        rng = generator(config.seed, "atlas detection", str(name))
        resampled = []
        for _ in range(RESAMPLES):
            chosen = np.concatenate(
                [members[i] for i in rng.integers(len(members), size=len(members))]
            )
            if 0 < moved[chosen].sum() < len(chosen):
                resampled.append(area_under_roc_curve(distance[chosen], moved[chosen]))
        low, high = np.quantile(resampled, [0.025, 0.975])
        rows.append(
            (name, len(moved), int(moved.sum()), area_under_roc_curve(distance, moved), low, high)
        )
    return pd.DataFrame(rows, columns=atlas_detection.column_names)
