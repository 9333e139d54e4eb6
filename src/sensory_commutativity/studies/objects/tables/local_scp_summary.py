"""Does the local SCP show where immovable things are?

The paper: low near walls and furniture and in the cramped kitchen, high in open space and over low things.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import mannwhitneyu

from ....seeding import generator
from ....statistics.aggregates import percentile_interval
from ....storage.tables import read_table, write_table
from ...config import Config

RESAMPLES = 2_000
DECIDED = {"predictor": "scp", "simulator": "scp_true"}


def area_under_curve(scp: np.ndarray, within: np.ndarray) -> float:
    """Area under the ROC curve of 1 - scp, float (n,), for `within`, bool (n,); NaN unless there are both kinds."""
    if within.all() or not within.any():
        return float("nan")
    return float(
        mannwhitneyu(-scp[within], -scp[~within]).statistic / (within.sum() * (~within).sum())
    )


def regions(table: pd.DataFrame, config: Config) -> dict[str, np.ndarray]:
    """Name -> which rows of a local_scp table belong to it, bool (n,)."""
    return {
        "open": (table["clearance"] > config.apartment.reach).to_numpy(),
        config.masks.map.cramped_room: (table["room"] == config.masks.map.cramped_room).to_numpy(),
        "over low things": table["over_low"].to_numpy(),
    }


def summarised(table: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Rows of the table local_scp_summary. Intervals: bootstrap over places, all headings of a place together."""
    rows = []
    for decided_by, column in DECIDED.items():
        rng = generator(config.seed, "masks", "map", "summary", decided_by)
        found = table.assign(scp=table[column])
        rows.append(("auc", "all", decided_by, *_with_interval(found, area_under_curve, rng)))
        for name, chosen in regions(table, config).items():
            rows.append(
                (
                    "median",
                    name,
                    decided_by,
                    *_with_interval(found[chosen], lambda scp, _: float(np.median(scp)), rng),
                )
            )
    return pd.DataFrame(
        rows, columns=["measure", "where", "decided_by", "n", "estimate", "ci_low", "ci_high"]
    )


def _with_interval(
    table: pd.DataFrame,
    measure: Callable[[np.ndarray, np.ndarray], float],
    rng: np.random.Generator,
) -> tuple[int, float, float, float]:
    """Number of rows, and a measure of their scp and within_reach with its interval."""
    if not len(table):
        return 0, float("nan"), float("nan"), float("nan")
    scp, within = table["scp"].to_numpy(), table["within_reach"].to_numpy(bool)
    groups = list(table.reset_index(drop=True).groupby(["x", "y"]).indices.values())
    resampled = []
    for _ in range(RESAMPLES):
        chosen = np.concatenate([groups[i] for i in rng.integers(len(groups), size=len(groups))])
        resampled.append(measure(scp[chosen], within[chosen]))
    defined = np.array(resampled)[np.isfinite(resampled)]
    return (
        len(table),
        measure(scp, within),
        *(percentile_interval(defined, 0.95) if len(defined) else (float("nan"), float("nan"))),
    )


def write_summary(local_scp: Path, out: Path, config: Config) -> None:
    """By the mask predictor, and by what the simulator knows."""
    write_table(
        "local_scp_summary", summarised(read_table("local_scp", local_scp), config), out, config
    )
