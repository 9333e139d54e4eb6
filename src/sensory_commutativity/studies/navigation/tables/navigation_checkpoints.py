"""Whether the action spaces differ at a checkpoint: Welch's test at each of them, for the marks
above the learning curves."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import PAIR
from ..runs import evaluation_steps
from .navigation_comparisons import pairs
from .navigation_curves import check_evaluations


def _expected(config: Config) -> Expected:
    rows = {(step, *pair): 1 for step in evaluation_steps(config) for pair in pairs(config)}
    return Expected(("step", "family", "a", "b"), rows)


@table(
    title="Comparisons of the action spaces at every checkpoint",
    columns=(
        Column("step", INT, "steps", "environment steps of training", key=True),
        *PAIR,
        Column("difference", FLOAT, "reward", "mean return of a minus that of b"),
        Column("ci_low", FLOAT, "reward", "lower end of its 95 % interval, not corrected"),
        Column("ci_high", FLOAT, "reward", "upper end"),
        Column("p", FLOAT, "1", "two-sided p-value of Welch's test", low=0, high=1),
        Column(
            "p_adjusted", FLOAT, "1",
            "p-value after Holm's correction over all checkpoints and pairs of the family",
            low=0, high=1,
        ),
    ),
    inputs=["navigation_curves"],
    settings=lambda config: config.navigation.action_spaces,
    expected=_expected,
)  # fmt: skip
def navigation_checkpoints(curves: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Every pair at every checkpoint."""
    from ....statistics.groups import welch
    from ....statistics.paired import holm

    check_evaluations(curves, config)
    rows = []
    for step, evaluations in curves.groupby("step"):
        returns = {
            name: runs["episode_return"].to_numpy()
            for name, runs in evaluations.groupby("action_space")
        }
        for family, a, b in pairs(config):
            test = welch(returns[a], returns[b])
            rows.append((step, family, a, b, test.difference, test.ci_low, test.ci_high, test.p))
    columns = ["step", "family", "a", "b", "difference", "ci_low", "ci_high", "p"]
    comparisons = pd.DataFrame(rows, columns=columns)
    by_family = comparisons.groupby("family")["p"]
    comparisons["p_adjusted"] = by_family.transform(lambda p: holm(p.to_numpy()))
    return comparisons
