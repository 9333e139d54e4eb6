"""Performance profiles: how many runs end with at least a return, for every return (Agarwal et al. 2021)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ....statistics.proportions import wilson_interval
from ....storage.tables import write_table
from ...config import Config
from .navigation_scores import read_scores


def write_profiles(scores: Path, out: Path, config: Config) -> None:
    """The fraction of runs whose final return is at least tau, for every tau that a return of the task can be."""
    table = read_scores(scores, config)
    rewards = [zone.reward for zone in config.navigation.zones]
    taus = np.linspace(min(0.0, *rewards), max(rewards), 141)
    frames = []
    for action_space in config.navigation.action_spaces:
        returns = table.loc[table["action_space"] == action_space, "final_return"].to_numpy()
        above = (returns[:, None] >= taus - 1e-9).sum(axis=0)
        low, high = wilson_interval(above, np.full(len(taus), len(returns)))
        frames.append(
            pd.DataFrame(
                dict(
                    threshold=taus,
                    n=len(returns),
                    above=above,
                    fraction=above / len(returns),
                    ci_low=low,
                    ci_high=high,
                )
            ).assign(action_space=action_space)
        )
    write_table("navigation_profiles", pd.concat(frames, ignore_index=True), out, config)
