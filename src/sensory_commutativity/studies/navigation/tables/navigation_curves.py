"""Learning curves of all training runs (paper, section IV-B)."""

from __future__ import annotations

from typing import NoReturn

import numpy as np
import pandas as pd

from ....errors import TableError, UserError
from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import Expected, Shard, table
from ..columns import RUN
from ..runs import TRAINING, evaluation_steps, training_runs


def check_evaluations(curves: pd.DataFrame, config: Config) -> None:
    """Check what the key of navigation_curves does not show.

    Raises
    ------
    TableError
        With the runs that were evaluated with another number of episodes, or whose mean return is
        not finite.
    """
    episodes = config.navigation.evaluation_episodes
    problems = {
        f"were not evaluated with {episodes} episodes": curves["episodes"] != episodes,
        "have a mean return that is not finite": ~np.isfinite(curves["episode_return"]),
    }
    for problem, rows in problems.items():
        runs = list(curves[rows].groupby(["action_space", "seed"]).groups)
        if runs:
            names = ", ".join(f"{action_space}.{seed}" for action_space, seed in runs[:5])
            more = f" and {len(runs) - 5} more" if len(runs) > 5 else ""
            raise TableError(
                f"navigation_curves: {len(runs)} of {len(config.navigation.runs)} training runs "
                f"{problem} ({names}{more}); delete their curves and run the workflow again"
            )


def _sort(curves: pd.DataFrame) -> pd.DataFrame:
    """In the order of the action spaces in the configuration, then by seed and step."""
    order = {action_space: i for i, action_space in enumerate(curves["action_space"].unique())}
    return curves.sort_values(
        ["action_space", "seed", "step"],
        key=lambda column: column.map(order) if column.name == "action_space" else column,
    )


def _expected(config: Config) -> Expected:
    steps = evaluation_steps(config)
    rows = {(*run, step): 1 for run in config.navigation.runs for step in steps}
    return Expected(("action_space", "seed", "step"), rows)


def _expected_shard(config: Config, shard: Shard) -> Expected:
    run = training_runs(config)[shard.run]
    rows = {(*run, step): 1 for step in evaluation_steps(config)}
    return Expected(("action_space", "seed", "step"), rows)


@table(
    title="Learning curves",
    columns=(
        *RUN,
        Column(
            "step", INT, "steps", "environment steps of training before the evaluation", key=True
        ),
        Column("episode_return", FLOAT, "reward", "mean return of the episodes"),
        Column(
            "success_rate", FLOAT, "1", "fraction of episodes that ended in the goal", low=0, high=1
        ),
        Column(
            "dead_rate", FLOAT, "1", "fraction of episodes that ended in a dead zone", low=0, high=1
        ),
        Column("episode_length", FLOAT, "steps", "mean length of the episodes", low=0),
        Column("episodes", INT, "1", "episodes of the evaluation"),
    ),
    inputs=["navigation_scp"],
    shards=TRAINING,
    gather=_sort,
    expected=_expected,
    expected_shard=_expected_shard,
)
def navigation_curves(scp: pd.DataFrame, config: Config, run: str) -> NoReturn:
    """The curve of one run, which training writes. Raises UserError."""
    raise UserError(
        f"the curve of {run} is written by training; run: train navigation_policy --run {run}"
    )
