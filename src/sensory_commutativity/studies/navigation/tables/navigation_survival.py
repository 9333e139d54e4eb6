"""How many runs have not yet learned the task after so many steps? Runs that never do are censored, not failed at some step."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....statistics.survival import kaplan_meier
from ....storage.tables import write_table
from ...config import Config
from .navigation_scores import read_scores


def write_survival(scores: Path, out: Path, config: Config) -> None:
    """Kaplan-Meier curves of the steps to the threshold return; runs that never reach it are censored at their end."""
    table = read_scores(scores, config)
    frames = []
    for action_space in config.navigation.action_spaces:
        runs = table[table["action_space"] == action_space]
        curve = kaplan_meier(runs["steps_to_threshold"].to_numpy(), runs["reached"].to_numpy())
        frames.append(
            pd.DataFrame(curve._asdict())
            .rename(columns={"time": "step"})
            .assign(action_space=action_space)
        )
    write_table("navigation_survival", pd.concat(frames, ignore_index=True), out, config)
