"""Performance profiles: how many runs end with at least a return, for every return (Agarwal et al.
2021, https://arxiv.org/abs/2108.13264)."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import ACTION_SPACE

RETURNS = 141
"""Returns of a profile, evenly spaced between the lowest and the highest possible one. Chosen: with
the paper's rewards, one for every half."""


@table(
    title="Performance profiles",
    columns=(
        ACTION_SPACE,
        Column("threshold", FLOAT, "reward", "final return", key=True),
        Column("n", INT, "1", "runs"),
        Column("above", INT, "1", "runs with at least this final return"),
        Column("fraction", FLOAT, "1", "their fraction", low=0, high=1),
        *INTERVAL,
    ),
    inputs=["navigation_scores"],
    settings=lambda config: [config.navigation.action_spaces, config.navigation.zones],
    expected=lambda config: Expected(
        ("action_space",), {(name,): RETURNS for name in config.navigation.action_spaces}
    ),
)
def navigation_profiles(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The fraction of runs whose final return is at least tau, for every possible tau."""
    from ....statistics.proportions import wilson_interval

    rewards = [zone.reward for zone in config.navigation.zones]
    taus = np.linspace(min(0.0, *rewards), max(rewards), RETURNS)
    frames = []
    for action_space in config.navigation.action_spaces:
        returns = scores.loc[scores["action_space"] == action_space, "final_return"].to_numpy()
        n = len(returns)
        above = (returns[:, None] >= taus - 1e-9).sum(axis=0)  # (taus,)
        low, high = wilson_interval(above, np.full(len(taus), n))
        profile = dict(threshold=taus, n=n, above=above, fraction=above / n, ci_low=low,
                       ci_high=high)  # fmt: skip
        frames.append(pd.DataFrame(profile).assign(action_space=action_space))
    return pd.concat(frames, ignore_index=True)
