"""How often do the tests err? A/A: two groups made from one action space's runs come from the same agent, so alpha of them should differ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ....seeding import generator
from ....statistics.calibration import binomial_band, resampled_rejections, split_rejections
from ....storage.tables import write_table
from ...config import Config
from .navigation_scores import read_scores

CALIBRATED = ("final_return", "auc", "steps_to_threshold")
TOGETHER = "all"
METHODS = HALVES, RESAMPLED = "halves", "resampled"


def write_calibration(scores: Path, out: Path, config: Config) -> None:
    """Make two groups of the runs of every action space again and again, and count the Welch tests between them that reject.

    The groups are random halves, or drawn with replacement, each as large as the action space's own. The comparisons are shared equally among the
    action spaces. The row "all" counts them together, but for action spaces whose runs all have the same score: no test can reject there.
    """
    table, navigation = read_scores(scores, config), config.navigation
    splits = -(-navigation.calibration_splits // len(navigation.action_spaces))
    rows = []
    for method, rejections in ((HALVES, split_rejections), (RESAMPLED, resampled_rejections)):
        for measure in CALIBRATED:
            rejected, counted = 0, 0
            for action_space in navigation.action_spaces:
                values = table.loc[table["action_space"] == action_space, measure].to_numpy()
                rng = generator(
                    config.seed, "navigation", "calibration", method, action_space, measure
                )
                k = rejections(values, splits, navigation.alpha, rng)
                rows.append((method, action_space, measure, splits, k))
                if np.ptp(values):
                    rejected, counted = rejected + k, counted + splits
            rows.append((method, TOGETHER, measure, counted, rejected))
    frame = pd.DataFrame(rows, columns=["method", "action_space", "measure", "splits", "rejected"])
    frame["alpha"] = navigation.alpha
    frame["rate"] = frame["rejected"] / frame["splits"].clip(lower=1)
    bands = [binomial_band(navigation.alpha, n) if n else (0.0, 0.0) for n in frame["splits"]]
    frame[["band_low", "band_high"]] = bands
    write_table("navigation_calibration", frame, out, config)
