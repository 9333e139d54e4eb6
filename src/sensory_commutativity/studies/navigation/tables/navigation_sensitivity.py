"""Does "more than twice as fast" depend on the threshold return, or on the runs that were first
looked at?

The comparison that decides is made again at other thresholds, and with the seeds that were drawn
before and after the first look at the data alone. Only the latter, with the rule as it was, confirm
it: the decision to draw them was made on the former.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from .navigation_curves import check_evaluations

PAIRS = (("truncated", "full"), ("adapted", "full"), ("truncated", "adapted"))
ALL, FIRST, CONFIRMATION = "all", "first look", "confirmation"


def looks(config: Config) -> dict[str, list[int]]:
    """Name of a set of runs -> its seeds; only ALL if no seeds were drawn for confirmation."""
    seeds, n = config.navigation.seeds, config.navigation.confirmation_seeds
    if not n:
        return {ALL: seeds}
    return {ALL: seeds, FIRST: seeds[:-n], CONFIRMATION: seeds[-n:]}


def thresholds(config: Config) -> list[float]:
    """The threshold that decides, and the others, in order."""
    navigation = config.navigation
    return sorted({navigation.threshold_return, *navigation.sensitivity_thresholds})


def _settings(config: Config) -> object:
    return [looks(config), thresholds(config), config.navigation.steps]


def _expected(config: Config) -> Expected:
    keys = product(looks(config), thresholds(config), PAIRS)
    return Expected(("runs", "threshold", "a", "b"), {(r, t, *pair): 1 for r, t, pair in keys})


@table(
    title="Steps to other threshold returns, and by the seeds drawn after the first look",
    columns=(
        Column(
            "runs", TEXT, "",
            "all; first look: seeds drawn before the data were looked at; confirmation: after",
            key=True,
        ),
        Column("threshold", FLOAT, "reward", "mean return that has to be reached", key=True),
        Column("a", TEXT, "", "action space", key=True),
        Column("b", TEXT, "", "action space that a is compared with", key=True),
        Column("n", INT, "1", "runs of each"),
        Column("censored_a", INT, "1", "runs of a that never reach the threshold"),
        Column("censored_b", INT, "1", "runs of b that never reach it"),
        Column("mean_a", FLOAT, "steps", "restricted mean of the steps of a", low=0),
        Column("mean_b", FLOAT, "steps", "of b", low=0),
        Column("ratio", FLOAT, "1", "mean_a / mean_b", low=0),
        Column("ci_low", FLOAT, "1", "lower end of its 95 % interval (bootstrap)", nullable=True),
        Column("ci_high", FLOAT, "1", "upper end", nullable=True),
        Column("p", FLOAT, "1", "Welch's test that a takes as many steps as b", low=0, high=1),
        Column("p_half", FLOAT, "1", "Welch's test that a takes half of them", low=0, high=1),
    ),
    inputs=["navigation_curves"],
    settings=_settings,
    expected=_expected,
)  # fmt: skip
def navigation_sensitivity(curves: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per set of runs, threshold and pair; p-values are not adjusted."""
    from ....statistics.aggregates import ratio_of_means
    from ....statistics.groups import welch

    check_evaluations(curves, config)
    rows = []
    for runs, seeds in looks(config).items():
        for threshold in thresholds(config):
            steps = {
                name: steps_to(curves, name, seeds, threshold, config.navigation.steps)
                for name in {name for pair in PAIRS for name in pair}
            }
            for a, b in PAIRS:
                (x, reached_x), (y, reached_y) = steps[a], steps[b]
                key = "navigation", "sensitivity", runs, f"{threshold:g}", a, b
                ratio = ratio_of_means(x, y, generator(config.seed, *key))
                rows.append(
                    (runs, threshold, a, b, len(x), int((~reached_x).sum()),
                     int((~reached_y).sum()), x.mean(), y.mean(), ratio.ratio,
                     *(end if np.isfinite(end) else np.nan for end in ratio[1:3]),
                     welch(x, y).p, welch(x, y / 2).p)
                )  # fmt: skip
    return pd.DataFrame(rows, columns=navigation_sensitivity.column_names)


def steps_to(
    curves: pd.DataFrame, action_space: str, seeds: list[int], threshold: float, most: int
) -> tuple[np.ndarray, np.ndarray]:
    """Steps before the first evaluation with a mean return, and whether it is reached.

    Returns
    -------
    steps : float64 (n,)
        In the order of the seeds; `most` for a run that never reaches the threshold.
    reached : bool (n,)
    """
    rows = curves[(curves["action_space"] == action_space) & curves["seed"].isin(seeds)]
    first = rows[rows["episode_return"] >= threshold].groupby("seed")["step"].min()
    steps = first.reindex(seeds)
    return steps.fillna(most).to_numpy(float), steps.notna().to_numpy()
