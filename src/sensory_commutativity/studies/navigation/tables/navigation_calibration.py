"""How often the tests err (A/A tests): two groups made from the runs of one action space belong to
the same agent, so a fraction alpha of the tests should reject."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import MEASURE
from .navigation_scores import STEPS

CALIBRATED = ("final_return", "auc", STEPS)
TOGETHER = "all"
HALVES, RESAMPLED = "halves", "resampled"


def _settings(config: Config) -> object:
    navigation = config.navigation
    return [navigation.action_spaces, navigation.calibration_splits, navigation.alpha]


def _expected(config: Config) -> Expected:
    spaces = (*config.navigation.action_spaces, TOGETHER)
    groups = [(method, space) for method in (HALVES, RESAMPLED) for space in spaces]
    return Expected(("method", "action_space"), dict.fromkeys(groups, len(CALIBRATED)))


@table(
    title="Calibration of the comparisons",
    columns=(
        Column(
            "method", TEXT, "",
            "how two groups are made from one: random halves, or resampled to full size", key=True,
        ),
        Column(
            "action_space", TEXT, "",
            "of the runs; all: together, except action spaces whose runs have equal scores",
            key=True,
        ),
        MEASURE,
        Column("splits", INT, "1", "pairs of groups that were compared (A/A)"),
        Column("rejected", INT, "1", "how many differed significantly"),
        Column("rate", FLOAT, "1", "their fraction", low=0, high=1),
        Column("alpha", FLOAT, "1", "the fraction to be expected", low=0, high=1),
        Column(
            "band_low", FLOAT, "1",
            "lower end of the central 95 % of the rate if comparisons were independent",
        ),
        Column("band_high", FLOAT, "1", "upper end"),
    ),
    inputs=["navigation_scores"],
    settings=_settings,
    expected=_expected,
)  # fmt: skip
def navigation_calibration(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Split the runs of every action space into two groups many times, and count Welch tests that
    reject.

    The groups are random halves, or drawn with replacement, each as large as the action space's
    own. The splits are shared equally among the action spaces. The row "all" counts them together,
    except for action spaces whose runs all have the same score, where no test can reject.
    """
    from ....statistics.calibration import (
        binomial_band,
        count_resampled_rejections,
        count_split_rejections,
    )

    navigation = config.navigation
    splits = -(-navigation.calibration_splits // len(navigation.action_spaces))
    methods = {HALVES: count_split_rejections, RESAMPLED: count_resampled_rejections}
    rows: list[tuple[str, str, str, int, int]] = []
    for method, count_rejections in methods.items():
        for measure in CALIBRATED:
            total_rejected, total_splits = 0, 0
            for space in navigation.action_spaces:
                values = scores.loc[scores["action_space"] == space, measure].to_numpy()
                rng = generator(config.seed, "navigation", "calibration", method, space, measure)
                rejected = count_rejections(values, splits, navigation.alpha, rng)
                rows.append((method, space, measure, splits, rejected))
                if np.ptp(values):
                    total_rejected += rejected
                    total_splits += splits
            rows.append((method, TOGETHER, measure, total_splits, total_rejected))
    frame = pd.DataFrame(rows, columns=["method", "action_space", "measure", "splits", "rejected"])
    frame["alpha"] = navigation.alpha
    frame["rate"] = frame["rejected"] / frame["splits"].clip(lower=1)
    bands = [binomial_band(navigation.alpha, n) if n else (0.0, 0.0) for n in frame["splits"]]
    frame[["band_low", "band_high"]] = bands
    return frame
