"""What each training run achieved: the scores that everything else is made from."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....storage.tables import read_table, write_table
from ...config import Config
from .navigation_curves import check_names, check_runs

MEASURES = ("final_return", "auc", "success_rate", "steps_to_threshold")
"""Scores that are compared; the first is the primary one. Of steps_to_threshold less is better."""


def score_runs(curves: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per run, in the order of the configuration; `curves` is a navigation_curves table."""
    navigation = config.navigation
    rows = []
    runs = dict(tuple(curves.groupby(["action_space", "seed"])))
    for action_space, seed in navigation.runs:
        curve = runs[action_space, seed].sort_values("step")
        last = curve.iloc[-1]
        there = curve["step"][curve["episode_return"] >= navigation.threshold_return]
        rows.append(
            dict(
                action_space=action_space,
                seed=seed,
                final_return=last["episode_return"],
                auc=curve["episode_return"].mean(),
                success_rate=last["success_rate"],
                steps_to_threshold=float(there.iloc[0] if len(there) else navigation.steps),
                reached=bool(len(there)),
                solved=bool(last["success_rate"] >= navigation.solved_success_rate),
            )
        )
    return pd.DataFrame(rows)


def write_scores(curves: Path, out: Path, config: Config) -> None:
    """Score the runs of a navigation_curves table. Raises TableError when a run is missing."""
    frame = read_table("navigation_curves", curves)
    check_runs(frame, config, str(curves))
    write_table("navigation_scores", score_runs(frame, config), out, config)


def read_scores(scores: Path, config: Config) -> pd.DataFrame:
    """The table navigation_scores. Raises TableError unless every run of the configuration is there, once."""
    frame = read_table("navigation_scores", scores)
    check_names(frame[["action_space", "seed"]], config, str(scores))
    return frame
