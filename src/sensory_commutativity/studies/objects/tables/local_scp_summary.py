"""Whether the local SCP shows where immovable objects are.

According to the paper it is low near walls and furniture and in the cramped kitchen, and high in
open space and over low furniture.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, INT, INTERVAL, TEXT, Column
from ...config import Config
from ...declarations import Expected, table

RESAMPLES = 2_000
DECIDED_BY = {"predictor": "scp", "simulator": "scp_true"}
"""Who decides the outcomes -> column of local_scp."""


def regions(poses: pd.DataFrame, config: Config) -> dict[str, np.ndarray]:
    """Name of a region -> which rows of a local_scp table belong to it, bool (n,)."""
    return {
        "open": (poses["clearance"] > config.apartment.reach).to_numpy(),
        config.masks.map.cramped_room: (poses["room"] == config.masks.map.cramped_room).to_numpy(),
        "over low things": poses["over_low"].to_numpy(),
    }


def _expected(config: Config) -> Expected:
    where = ["open", config.masks.map.cramped_room, "over low things"]
    chosen = [("auc", "all"), *(("median", name) for name in where)]
    rows: dict[tuple, int | None] = {(*one, name): 1 for one in chosen for name in DECIDED_BY}
    return Expected(("measure", "where", "decided_by"), rows)


@table(
    title="Local SCP of the regions of the map",
    columns=(
        Column(
            "measure", TEXT, "",
            "auc: area under the ROC curve of 1 - scp for within_reach; median: median local SCP",
            key=True,
        ),
        Column(
            "where", TEXT, "",
            "all poses; open: nothing within apartment.reach of the swept arm; the cramped room; "
            "over low furniture", key=True,
        ),
        Column(
            "decided_by", TEXT, "", "predictor: the masks; simulator: the true outcomes", key=True
        ),
        Column("n", INT, "1", "poses"),
        Column("estimate", FLOAT, "1", "of the measure; missing if undefined", nullable=True),
        *INTERVAL,
    ),
    inputs=["local_scp"],
    settings=lambda config: [config.apartment.reach, config.masks.map.cramped_room],
    expected=_expected,
)  # fmt: skip
def local_scp_summary(poses: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Intervals: bootstrap over positions, all headings of a position together."""
    from ....statistics.clusters import area_under_roc_curve

    def auc(scp: np.ndarray, within: np.ndarray) -> float:
        return area_under_roc_curve(-scp, within)

    def median(scp: np.ndarray, within: np.ndarray) -> float:
        return float(np.median(scp))

    rows = []
    for decided_by, column in DECIDED_BY.items():
        rng = generator(config.seed, "masks", "map", "summary", decided_by)
        decided = poses.assign(scp=poses[column])
        rows.append(("auc", "all", decided_by, *_estimate(decided, auc, rng)))
        for name, chosen in regions(poses, config).items():
            rows.append(("median", name, decided_by, *_estimate(decided[chosen], median, rng)))
    return pd.DataFrame(rows, columns=local_scp_summary.column_names)


def _estimate(
    poses: pd.DataFrame,
    measure: Callable[[np.ndarray, np.ndarray], float],
    rng: np.random.Generator,
) -> tuple[int, float, float, float]:
    """Number of rows, a measure of their scp and within_reach, and its interval."""
    from ....statistics.aggregates import percentile_interval

    if not len(poses):
        return 0, float("nan"), float("nan"), float("nan")
    scp, within = poses["scp"].to_numpy(), poses["within_reach"].to_numpy(bool)
    groups = list(poses.reset_index(drop=True).groupby(["x", "y"]).indices.values())
    resampled = []
    for _ in range(RESAMPLES):
        drawn = rng.integers(len(groups), size=len(groups))
        rows = np.concatenate([groups[i] for i in drawn])
        resampled.append(measure(scp[rows], within[rows]))
    defined = np.array(resampled)[np.isfinite(resampled)]
    low, high = percentile_interval(defined, 0.95) if len(defined) else (float("nan"), float("nan"))
    return len(poses), measure(scp, within), low, high
