"""The runs of every action space in a few numbers."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....seeding import generator
from ....statistics.aggregates import summary
from ....statistics.proportions import wilson_interval
from ....storage.tables import write_table
from ...config import Config
from .navigation_scores import MEASURES, read_scores


def summarise(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Mean, median and interquartile mean of every score, and the fractions of runs that reached the threshold and solved the task."""
    rows = []
    for action_space in config.navigation.action_spaces:
        runs = scores[scores["action_space"] == action_space]
        for measure in MEASURES:
            found = summary(
                runs[measure].to_numpy(),
                generator(config.seed, "navigation", "summary", action_space, measure),
            )
            rows.append(dict(action_space=action_space, measure=measure, **found._asdict()))
        for measure in ("reached", "solved"):
            k, n = int(runs[measure].sum()), len(runs)
            low, high = wilson_interval(k, n)
            rows.append(
                dict(
                    action_space=action_space,
                    measure=measure,
                    n=n,
                    mean=k / n,
                    mean_low=float(low),
                    mean_high=float(high),
                )
            )
    return pd.DataFrame(rows)


def write_summary(scores: Path, out: Path, config: Config) -> None:
    write_table("navigation_summary", summarise(read_scores(scores, config), config), out, config)
