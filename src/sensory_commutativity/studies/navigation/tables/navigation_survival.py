"""How many runs have not yet reached the threshold return after a number of steps. Runs that never
reach it are censored at their end."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import ACTION_SPACE
from .navigation_scores import STEPS


@table(
    title="Survival curves of the steps to the threshold return",
    columns=(
        ACTION_SPACE,
        Column("step", FLOAT, "steps", "environment steps of training", key=True),
        Column("at_risk", INT, "1", "runs that had not reached the threshold before"),
        Column("events", INT, "1", "runs that reached it at this step"),
        Column(
            "survival", FLOAT, "1",
            "Kaplan-Meier estimate of the fraction of runs that have not reached it", low=0, high=1,
        ),
        *INTERVAL,
    ),
    inputs=["navigation_scores"],
    settings=lambda config: config.navigation.action_spaces,
    expected=lambda config: Expected(
        ("action_space",), {(name,): None for name in config.navigation.action_spaces}
    ),
)  # fmt: skip
def navigation_survival(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The Kaplan-Meier curve of every action space."""
    from ....statistics.survival import kaplan_meier

    frames = []
    for action_space in config.navigation.action_spaces:
        runs = scores[scores["action_space"] == action_space]
        curve = kaplan_meier(runs[STEPS].to_numpy(), runs["reached"].to_numpy())
        frame = pd.DataFrame(curve._asdict()).rename(columns={"time": "step"})
        frames.append(frame.assign(action_space=action_space))
    return pd.concat(frames, ignore_index=True)
