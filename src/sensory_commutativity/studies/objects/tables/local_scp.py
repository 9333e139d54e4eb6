"""The local SCP at every pose of the map, according to the mask predictor, and what truly is within
reach there (paper, Fig. "SCP map").

Experiments are played, and their final pictures stored, before any predictor is trained; another
predictor can be applied to the same pictures.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from ....storage.columns import BOOL, FLOAT, INT, INTERVAL, TEXT, Column
from ...config import Config
from ...declarations import Batched, Expected, table
from .mask_comparisons import REFERENCE_MODEL

if TYPE_CHECKING:
    from ....change_detection.predictor import MaskPredictor


@table(
    title="Local SCP at every pose of the map",
    columns=(
        Column("apartment", TEXT, "", "a key of apartment.scenes", key=True),
        Column("dof", TEXT, "", "degree of freedom: the arm joint nearest the body", key=True),
        Column("room", TEXT, "", "area of the floor plan", key=True),
        Column("x", FLOAT, "m", "position of the robot", key=True),
        Column("y", FLOAT, "m", "position of the robot", key=True),
        Column("heading", FLOAT, "rad", "heading of the robot", key=True),
        Column("n", INT, "1", "SC-experiments"),
        Column("different", INT, "1", "how many the mask predictor calls different"),
        Column("scp", FLOAT, "1", "local SCP: the fraction of the others", low=0, high=1),
        *INTERVAL,
        Column(
            "scp_true", FLOAT, "1", "the same by the outcomes that the simulator knows",
            low=0, high=1,
        ),
        Column(
            "clearance", FLOAT, "m",
            "from the swept arm to the nearest fixture, median over the starts of the experiments; "
            "at most 1, below 0 inside it",
        ),
        Column(
            "within_reach", BOOL, "",
            "whether the arm, swept as far as half of all experiments reach, meets a fixture in "
            "half of them",
        ),
        Column("nearest_object", TEXT, "", "nearest fixture; empty if none is within a metre"),
        Column(
            "over_low", BOOL, "",
            "whether the swept arm mostly passes over low furniture, and meets nothing",
        ),
    ),
    inputs=[f"mask_predictor/{REFERENCE_MODEL}", "local_scp_experiments"],
    settings=lambda config: config.masks.map.scene,
    expected=lambda config: Expected((), {}),  # no pose may be free at a coarse spacing
)  # fmt: skip
def local_scp(predictor: Path, experiments: list[Path], config: Config) -> Batched:
    """Apply a predictor to the pictures of all poses."""
    from ....change_detection.predictor import load_predictor

    loaded = load_predictor(predictor, REFERENCE_MODEL)

    def compute(start: int, stop: int) -> pd.DataFrame:
        rows = [row for path in experiments[start:stop] for row in _rows(path, loaded, config)]
        return pd.DataFrame(rows, columns=local_scp.column_names)

    return Batched(compute, size=1, units=len(experiments))


def _rows(path: Path, predictor: MaskPredictor, config: Config) -> list[tuple]:
    """Rows of the table for one file of experiments."""
    from ....change_detection.decision import classify_outcomes
    from ....change_detection.outcome import OUTCOMES
    from ....statistics.proportions import wilson_interval
    from ....storage.arrays import read_arrays

    arrays, texts = read_arrays(path, "local_scp_experiments")
    rooms, nearest = texts.json_list("rooms"), texts.json_list("nearest")
    n = config.masks.map.experiments
    predicted = classify_outcomes(predictor.predict_proba(arrays["pictures"]), predictor.thresholds)
    different = (predicted == OUTCOMES.index("different")).reshape(-1, n)
    rows = []
    for k, (room, pose) in enumerate(zip(rooms, arrays["pose"], strict=True)):
        same, clearance = int((~different[k]).sum()), float(arrays["clearance"][k])
        low, high = (float(end) for end in wilson_interval(same, n))
        within = clearance <= 0
        rows.append(
            (config.masks.map.scene, texts["dof"], room, *(float(value) for value in pose), n,
             n - same, same / n, low, high, float((~arrays["different"][k]).mean()), clearance,
             within, nearest[k], bool(arrays["over_low"][k]) and not within)
        )  # fmt: skip
    return rows
