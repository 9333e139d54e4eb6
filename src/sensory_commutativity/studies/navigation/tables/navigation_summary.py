"""Averages of the scores over the runs of every action space."""

from __future__ import annotations

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import ACTION_SPACE
from .navigation_scores import MEASURES

FRACTIONS = ("reached", "solved")
"""Columns of navigation_scores of which the fraction of runs is given."""
UNIT = "of the measure"


def _expected(config: Config) -> Expected:
    spaces = config.navigation.action_spaces
    measures = (*MEASURES, *FRACTIONS)
    rows = {(space, measure): 1 for space in spaces for measure in measures}
    return Expected(("action_space", "measure"), rows)


@table(
    title="Averages of the scores of every action space",
    columns=(
        ACTION_SPACE,
        Column(
            "measure", TEXT, "",
            "a score, or the fraction of runs that reached the threshold or solved the task",
            key=True,
        ),
        Column("n", INT, "1", "runs"),
        Column("mean", FLOAT, UNIT, "mean"),
        Column(
            "mean_low", FLOAT, UNIT,
            "lower end of its 95 % interval: Student's t, or Wilson's for fractions of runs",
        ),
        Column("mean_high", FLOAT, UNIT, "upper end"),
        Column("median", FLOAT, UNIT, "median", nullable=True),
        Column(
            "median_low", FLOAT, UNIT, "lower end of its 95 % interval, bootstrap", nullable=True
        ),
        Column("median_high", FLOAT, UNIT, "upper end", nullable=True),
        Column("iqm", FLOAT, UNIT, "interquartile mean", nullable=True),
        Column("iqm_low", FLOAT, UNIT, "lower end of its 95 % interval, bootstrap", nullable=True),
        Column("iqm_high", FLOAT, UNIT, "upper end", nullable=True),
    ),
    inputs=["navigation_scores"],
    settings=lambda config: config.navigation.action_spaces,
    expected=_expected,
)  # fmt: skip
def navigation_summary(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per action space and measure."""
    from ....statistics.aggregates import summarize
    from ....statistics.proportions import wilson_interval

    rows = []
    for action_space in config.navigation.action_spaces:
        runs = scores[scores["action_space"] == action_space]
        for measure in MEASURES:
            rng = generator(config.seed, "navigation", "summary", action_space, measure)
            summary = summarize(runs[measure].to_numpy(), rng)
            rows.append(dict(action_space=action_space, measure=measure, **summary._asdict()))
        for measure in FRACTIONS:
            k, n = int(runs[measure].sum()), len(runs)
            low, high = wilson_interval(np.array([k]), np.array([n]))
            rows.append(
                dict(action_space=action_space, measure=measure, n=n, mean=k / n,
                     mean_low=float(low[0]), mean_high=float(high[0]))
            )  # fmt: skip
    return pd.DataFrame(rows)
