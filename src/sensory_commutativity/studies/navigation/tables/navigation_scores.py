"""Scores of every training run, on which all comparisons are based."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import BOOL, FLOAT, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import RUN
from .navigation_curves import check_evaluations

STEPS = "steps_to_threshold"
MEASURES = ("final_return", "auc", "success_rate", STEPS)
"""Scores that are compared. Less is better for steps_to_threshold, more for the others."""


def _settings(config: Config) -> object:
    navigation = config.navigation
    return [navigation.action_spaces, navigation.seeds, navigation.steps,
            navigation.threshold_return, navigation.solved_success_rate]  # fmt: skip


@table(
    title="Scores of every training run",
    columns=(
        *RUN,
        Column("final_return", FLOAT, "reward", "mean return at the last evaluation"),
        Column(
            "auc", FLOAT, "reward",
            "mean return over all evaluations: the area under the learning curve",
        ),
        Column(
            "success_rate", FLOAT, "1",
            "fraction of episodes that ended in the goal at the last evaluation", low=0, high=1,
        ),
        Column(
            STEPS, FLOAT, "steps",
            "steps before the first evaluation with the threshold return; all steps if none has it",
        ),
        Column(
            "reached", BOOL, "",
            "whether the threshold return was reached; if not, steps_to_threshold is censored",
        ),
        Column(
            "solved", BOOL, "",
            "whether the last evaluation has the success rate that counts as solved",
        ),
    ),
    inputs=["navigation_curves"],
    settings=_settings,
    expected=lambda config: Expected(
        ("action_space", "seed"), dict.fromkeys(config.navigation.runs, 1)
    ),
)  # fmt: skip
def navigation_scores(curves: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per run, in the order of the configuration."""
    check_evaluations(curves, config)
    navigation = config.navigation
    rows = []
    curve_of_run = dict(tuple(curves.groupby(["action_space", "seed"])))
    for action_space, seed in navigation.runs:
        curve = curve_of_run[action_space, seed].sort_values("step")
        last = curve.iloc[-1]
        reached = curve["step"][curve["episode_return"] >= navigation.threshold_return]
        row = {
            "action_space": action_space,
            "seed": seed,
            "final_return": last["episode_return"],
            "auc": curve["episode_return"].mean(),
            "success_rate": last["success_rate"],
            STEPS: float(reached.iloc[0] if len(reached) else navigation.steps),
            "reached": bool(len(reached)),
            "solved": bool(last["success_rate"] >= navigation.solved_success_rate),
        }
        rows.append(row)
    return pd.DataFrame(rows)
