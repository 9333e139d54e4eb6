"""Whether the action spaces differ: Welch's test with Holm's correction decides. Other tests are
computed beside it, to show whether they agree.

The paper's three pairs are one family, the pairs with a control another. Steps to the threshold are
censored at the end of a run. Welch's test uses the length of the run there, and thus compares
restricted means, the mean steps within the budget; the log-rank test handles censored runs.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ....seeding import generator
from ....storage.columns import FLOAT, P_VALUES, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..columns import MEASURE, PAIR
from ..config import PAPER_SPACES
from .navigation_scores import MEASURES, STEPS

if TYPE_CHECKING:
    from ....statistics.groups import PairComparison

CROSS_CHECKED = ("final_return", "auc", STEPS)
"""Measures with a Games-Howell test, whose studentised range takes seconds."""
WELCH, RANKS, HOWELL = "Welch", "Welch, ranks", "Games-Howell"
MANN_WHITNEY, PERMUTATION = "Mann-Whitney", "permutation"
HALF, LOG_RANK = "Welch, against half of b", "log-rank"
_FASTEST_FIRST = ("truncated", "adapted", "base-random", "random-half", "full", "inverse")
"""Expected order of learning, according to the paper or, for the controls, to their design."""


def pairs(config: Config) -> list[tuple[str, str, str]]:
    """(family, a, b) of all pairs; a is expected to learn faster than b."""
    spaces = [name for name in _FASTEST_FIRST if name in config.navigation.action_spaces]
    families = [
        ("paper" if {a, b} <= set(PAPER_SPACES) else "controls", a, b)
        for a, b in combinations(spaces, 2)
    ]
    return sorted(families, key=lambda pair: pair[0] != "paper")


def _howell_row(
    comparisons: dict[tuple[str, str], PairComparison], a: str, b: str
) -> dict[str, float]:
    """The comparison of a with b, whichever way round it was computed."""
    sign = 1 if (a, b) in comparisons else -1
    pair = comparisons[(a, b) if sign == 1 else (b, a)]
    low, high = sorted((sign * pair.ci_low, sign * pair.ci_high))
    return dict(p=pair.p, difference=sign * pair.difference, ci_low=low, ci_high=high)


def _compare_pair(
    pair: dict[str, str],
    a: pd.DataFrame,
    b: pd.DataFrame,
    howell: dict[str, float] | None,
    rng: np.random.Generator,
) -> Iterator[dict[str, Any]]:
    """Yield a row per test of one measure; `a` and `b` are the scores of the runs."""
    from scipy.stats import rankdata

    from ....statistics.groups import (
        mann_whitney,
        permutation_test,
        probability_of_improvement,
        welch,
    )

    x, y = a[pair["measure"]].to_numpy(), b[pair["measure"]].to_numpy()  # (runs,) each
    yield dict(**pair, test=WELCH, effect="Hedges' g", **welch(x, y)._asdict())
    ranks = rankdata(np.concatenate([x, y]))
    test = welch(ranks[: len(x)], ranks[len(x) :])
    yield dict(
        **pair, test=RANKS, statistic=test.statistic, df=test.df, p=test.p,
        effect="Hedges' g of ranks", effect_size=test.effect_size,
    )  # fmt: skip
    if howell is not None:
        yield dict(**pair, test=HOWELL, effect="", **howell)
    better = (y, x) if pair["measure"] == STEPS else (x, y)
    improvement = probability_of_improvement(*better, rng)
    yield dict(
        **pair, test=MANN_WHITNEY, **mann_whitney(x, y)._asdict(), effect="P(a better)",
        effect_size=improvement.probability, ci_low=improvement.ci_low, ci_high=improvement.ci_high,
    )  # fmt: skip
    p = permutation_test(x, y, rng)
    yield dict(**pair, test=PERMUTATION, p=p, difference=x.mean() - y.mean(), effect="")
    if pair["measure"] == STEPS:
        yield from compare_steps(pair, a, b, rng)


def compare_steps(
    pair: dict[str, str], a: pd.DataFrame, b: pd.DataFrame, rng: np.random.Generator
) -> Iterator[dict[str, Any]]:
    """Yield the rows of the tests that are for times to an event alone."""
    from ....statistics.aggregates import ratio_of_means
    from ....statistics.groups import welch
    from ....statistics.survival import log_rank

    x, y = a[STEPS].to_numpy(), b[STEPS].to_numpy()
    test = log_rank(x, a["reached"].to_numpy(), y, b["reached"].to_numpy())
    yield dict(**pair, test=LOG_RANK, statistic=test.statistic, p=test.p, effect="")
    half = welch(x, y / 2)
    ratio = ratio_of_means(x, y, rng)
    yield dict(
        **pair, test=HALF, statistic=half.statistic, df=half.df, p=half.p,
        effect="ratio of mean steps, a / b", effect_size=ratio.ratio,
        ci_low=ratio.ci_low, ci_high=ratio.ci_high,
    )  # fmt: skip


def _adjust(comparisons: pd.DataFrame) -> pd.Series:
    """p-values after Holm's correction over the pairs of a family, for each measure and test.

    Those of the Games-Howell test hold for all pairs already.
    """
    from ....statistics.paired import holm

    adjusted = comparisons["p"].copy()
    corrected = comparisons[comparisons["test"] != HOWELL]
    for _, rows in corrected.groupby(["family", "measure", "test"]):
        adjusted[rows.index] = holm(rows["p"].to_numpy())
    return adjusted


def _agree(comparisons: pd.DataFrame, alpha: float) -> np.ndarray:
    """Whether each test decides as Welch's does; see the column agrees."""
    significant = comparisons["p_adjusted"] < alpha
    keys = pd.MultiIndex.from_frame(comparisons[["a", "b", "measure"]])
    welch = (comparisons["test"] == WELCH).to_numpy()
    decision = pd.Series(significant[welch].to_numpy(), keys[welch])
    agrees = significant.to_numpy() == decision[keys].to_numpy()
    same_question = ~comparisons["test"].isin([WELCH, HALF])
    return np.where(same_question, np.where(agrees, "yes", "no"), "")


def _expected(config: Config) -> Expected:
    tests = 4 * len(MEASURES) + len(CROSS_CHECKED) + 2
    return Expected(("family", "a", "b"), dict.fromkeys(pairs(config), tests))


@table(
    title="Comparisons of the action spaces",
    columns=(
        *PAIR,
        MEASURE,
        Column("test", TEXT, "", "name of the test; Welch decides", key=True),
        Column("statistic", FLOAT, "1", "statistic of the test", nullable=True),
        Column("df", FLOAT, "1", "degrees of freedom", nullable=True),
        *P_VALUES,
        Column("difference", FLOAT, "of the measure", "mean of a minus mean of b", nullable=True),
        Column(
            "ci_low", FLOAT, "of the measure",
            "lower end of the 95 % interval of the difference or, without one, of the effect size",
            nullable=True,
        ),
        Column("ci_high", FLOAT, "of the measure", "upper end", nullable=True),
        Column("effect", TEXT, "", "what effect_size is"),
        Column(
            "effect_size", FLOAT, "1",
            "Hedges' g, the probability that a run of a is better, or the ratio of the mean steps",
            nullable=True,
        ),
        Column(
            "agrees", TEXT, "",
            "yes or no: whether the test decides as Welch's; empty for Welch's and other questions",
        ),
    ),
    inputs=["navigation_scores"],
    settings=lambda config: [config.navigation.action_spaces, config.navigation.alpha],
    expected=_expected,
)  # fmt: skip
def navigation_comparisons(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """All tests of all pairs on all measures."""
    from ....statistics.groups import games_howell

    groups = dict(tuple(scores.groupby("action_space", sort=False)))
    howell = {}
    for family in dict.fromkeys(family for family, _, _ in pairs(config)):
        members = PAPER_SPACES if family == "paper" else tuple(groups)
        for measure in CROSS_CHECKED:
            values = {name: groups[name][measure].to_numpy() for name in members}
            howell[family, measure] = games_howell(values)
    rows: list[dict[str, Any]] = []
    for family, a, b in pairs(config):
        for measure in MEASURES:
            pair = dict(family=family, a=a, b=b, measure=measure)
            comparisons = howell.get((family, measure))
            howell_row = _howell_row(comparisons, a, b) if comparisons else None
            rng = generator(config.seed, "navigation", "comparisons", a, b, measure)
            rows += _compare_pair(pair, groups[a], groups[b], howell_row, rng)
    frame = pd.DataFrame(rows)
    frame["p_adjusted"] = _adjust(frame)
    frame["agrees"] = _agree(frame, config.navigation.alpha)
    return frame
