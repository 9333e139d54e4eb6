"""Do the action spaces differ? Welch's test with Holm's correction decides; the other tests stand beside it, whether they agree or not.

The paper's three pairs are one family, the pairs with a control another. Steps to the threshold are censored at the end of a run: Welch sees the
length of the run there, so it compares restricted means, the mean steps within the budget; the log-rank test treats censored runs as what they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import rankdata

from ....seeding import generator
from ....statistics.aggregates import ratio_of_means
from ....statistics.groups import (
    games_howell,
    mann_whitney,
    permutation,
    probability_of_improvement,
    welch,
)
from ....statistics.paired import holm
from ....statistics.survival import log_rank
from ....storage.tables import write_table
from ...config import Config
from ..config import PAPER_SPACES
from .navigation_scores import MEASURES, read_scores

STEPS = "steps_to_threshold"
CROSS_CHECKED = ("final_return", "auc", STEPS)
"""Measures with Games and Howell's test, whose studentised range takes seconds."""

WELCH, RANKS, HOWELL, HALF, LOG_RANK = (
    "Welch",
    "Welch, ranks",
    "Games-Howell",
    "Welch, against half of b",
    "log-rank",
)
_EXPECTED = ("truncated", "adapted", "random-half", "full", "inverse")


def pairs(config: Config) -> list[tuple[str, str, str]]:
    """(family, a, b) of all pairs; a is the one that the paper, or common sense, expects to learn faster."""
    spaces = [name for name in _EXPECTED if name in config.navigation.action_spaces]
    found = [
        ("paper" if {a, b} <= set(PAPER_SPACES) else "controls", a, b)
        for a, b in combinations(spaces, 2)
    ]
    return sorted(found, key=lambda pair: pair[0] != "paper")


def compare(scores: pd.DataFrame, config: Config) -> pd.DataFrame:
    """All tests of all pairs on all measures; `scores` is a navigation_scores table."""
    groups = dict(tuple(scores.groupby("action_space", sort=False)))
    together = {
        (family, measure): games_howell(
            {name: groups[name][measure].to_numpy() for name in members}
        )
        for family, members in (("paper", PAPER_SPACES), ("controls", tuple(groups)))
        for measure in CROSS_CHECKED
    }
    frame = pd.DataFrame(
        [
            row
            for family, a, b in pairs(config)
            for row in _tests(family, a, b, groups, together, config)
        ]
    )
    frame["p_adjusted"] = frame["p"]
    for _, rows in frame[frame["test"] != HOWELL].groupby(["family", "measure", "test"]):
        frame.loc[rows.index, "p_adjusted"] = holm(rows["p"].to_numpy())
    decided = (
        frame[frame["test"] == WELCH].set_index(["a", "b", "measure"])["p_adjusted"]
        < config.navigation.alpha
    )
    same_question = ~frame["test"].isin([WELCH, HALF])
    agrees = (frame["p_adjusted"] < config.navigation.alpha) == [
        decided[row] for row in zip(frame["a"], frame["b"], frame["measure"], strict=True)
    ]
    frame["agrees"] = np.where(same_question, np.where(agrees, "yes", "no"), "")
    return frame


def _tests(
    family: str,
    a: str,
    b: str,
    groups: dict[str, pd.DataFrame],
    together: dict[tuple[str, str], Any],
    config: Config,
) -> Iterator[dict[str, Any]]:
    for measure in MEASURES:
        pair = dict(family=family, a=a, b=b, measure=measure)
        x, y = groups[a][measure].to_numpy(), groups[b][measure].to_numpy()
        rng = generator(config.seed, "navigation", "comparisons", a, b, measure)
        yield dict(**pair, test=WELCH, effect="Hedges' g", **welch(x, y)._asdict())
        ranks = rankdata(np.concatenate([x, y]))
        test = welch(ranks[: len(x)], ranks[len(x) :])
        yield dict(
            **pair,
            test=RANKS,
            statistic=test.statistic,
            df=test.df,
            p=test.p,
            effect="Hedges' g of ranks",
            effect_size=test.effect_size,
        )
        if measure in CROSS_CHECKED:
            howell = together[family, measure]
            found, sign = (howell[a, b], 1) if (a, b) in howell else (howell[b, a], -1)
            ends = sorted((sign * found.ci_low, sign * found.ci_high))
            yield dict(
                **pair,
                test=HOWELL,
                p=found.p,
                difference=sign * found.difference,
                ci_low=ends[0],
                ci_high=ends[1],
                effect="",
            )
        better = (y, x) if measure == STEPS else (x, y)
        improvement = probability_of_improvement(*better, rng)
        yield dict(
            **pair, test="Mann-Whitney", **mann_whitney(x, y)._asdict(), effect="P(a better)", effect_size=improvement.probability,
            ci_low=improvement.ci_low, ci_high=improvement.ci_high,
        )  # fmt: skip
        yield dict(
            **pair,
            test="permutation",
            p=permutation(x, y, rng),
            difference=x.mean() - y.mean(),
            effect="",
        )
        if measure == STEPS:
            yield from _steps(pair, groups[a], groups[b], rng)


def _steps(
    pair: dict[str, str], a: pd.DataFrame, b: pd.DataFrame, rng: Any
) -> Iterator[dict[str, Any]]:
    """What only times to an event allow."""
    test = log_rank(
        a[STEPS].to_numpy(), a["reached"].to_numpy(), b[STEPS].to_numpy(), b["reached"].to_numpy()
    )
    yield dict(**pair, test=LOG_RANK, statistic=test.statistic, p=test.p, effect="")
    half = welch(a[STEPS].to_numpy(), b[STEPS].to_numpy() / 2)
    ratio = ratio_of_means(a[STEPS].to_numpy(), b[STEPS].to_numpy(), rng)
    yield dict(
        **pair, test=HALF, statistic=half.statistic, df=half.df, p=half.p, effect="ratio of mean steps, a / b", effect_size=ratio.ratio,
        ci_low=ratio.ci_low, ci_high=ratio.ci_high,
    )  # fmt: skip


def write_comparisons(scores: Path, out: Path, config: Config) -> None:
    frame = compare(read_scores(scores, config), config)
    write_table("navigation_comparisons", frame, out, config)
