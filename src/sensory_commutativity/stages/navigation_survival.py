"""How many runs have not yet learned the task after so many steps, and how many end above a return: curves over all runs of an action space."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ..config import Config
from ..statistics.proportions import wilson_interval
from ..statistics.survival import kaplan_meier
from ..tables import read_table, write_table


def write_survival(scores: Path, out: Path, config: Config) -> None:
    """Kaplan-Meier curves of the steps to the threshold return; runs that never reach it are censored at their end."""
    table = read_table("navigation_scores", scores)
    frames = []
    for action_space in config.navigation.action_spaces:
        runs = table[table["action_space"] == action_space]
        curve = kaplan_meier(runs["steps_to_threshold"].to_numpy(), runs["reached"].to_numpy())
        frames.append(pd.DataFrame(curve._asdict()).rename(columns={"time": "step"}).assign(action_space=action_space))
    write_table("navigation_survival", pd.concat(frames, ignore_index=True), out, config)


def write_profiles(scores: Path, out: Path, config: Config) -> None:
    """Performance profiles: the fraction of runs whose final return is at least tau, for every tau that a return of the task can be."""
    table = read_table("navigation_scores", scores)
    rewards = [zone.reward for zone in config.navigation.zones]
    taus = np.linspace(min(0.0, *rewards), max(rewards), 141)
    frames = []
    for action_space in config.navigation.action_spaces:
        returns = table.loc[table["action_space"] == action_space, "final_return"].to_numpy()
        above = (returns[:, None] >= taus - 1e-9).sum(axis=0)
        low, high = wilson_interval(above, np.full(len(taus), len(returns)))
        frames.append(
            pd.DataFrame(dict(threshold=taus, n=len(returns), above=above, fraction=above / len(returns), ci_low=low, ci_high=high)).assign(
                action_space=action_space
            )
        )
    write_table("navigation_profiles", pd.concat(frames, ignore_index=True), out, config)
