"""Do the action spaces differ at a checkpoint? Welch's test at each of them, for the marks above the learning curves."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....statistics.groups import welch
from ....statistics.paired import holm
from ....storage.tables import read_table, write_table
from ...config import Config
from .navigation_comparisons import pairs
from .navigation_curves import check_runs


def compare_checkpoints(curves: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Welch at every checkpoint of every pair, Holm over all checkpoints and pairs of a family; `curves` is a navigation_curves table."""
    rows = []
    for step, evaluation in curves.groupby("step"):
        groups = {
            name: runs["episode_return"].to_numpy()
            for name, runs in evaluation.groupby("action_space")
        }
        for family, a, b in pairs(config):
            test = welch(groups[a], groups[b])
            rows.append((step, family, a, b, test.difference, test.ci_low, test.ci_high, test.p))
    frame = pd.DataFrame(
        rows, columns=["step", "family", "a", "b", "difference", "ci_low", "ci_high", "p"]
    )
    frame["p_adjusted"] = frame.groupby("family")["p"].transform(lambda p: holm(p.to_numpy()))
    return frame


def write_checkpoints(curves: Path, out: Path, config: Config) -> None:
    frame = read_table("navigation_curves", curves)
    check_runs(frame, config, str(curves))
    write_table("navigation_checkpoints", compare_checkpoints(frame, config), out, config)
