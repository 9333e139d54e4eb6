"""Sampling until the order of the degrees of freedom is decided: errors, and what it saves.

Runs are simulated. The cases of Flatland resample the recorded experiments of a world, all degrees
of freedom together; in the others all SCPs are equal, or differ by exactly the margin, where wrong
decisions are likeliest.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd

from ....seeding import generator
from ....statistics.sequential import HIGHER, LOWER, TIED, UNDECIDED, SequentialOrder, pair_levels
from ....storage.columns import FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import table
from ...flatland.builders import DOFS
from ..builders import reset_free
from ..config import SequentialConfig
from ..estimates import shares_starts

LOOK = 10
"""Starts between two looks. Chosen."""
EQUAL = 0.9
"""SCP of all degrees of freedom in the case "equal". Chosen: near those of Flatland."""

SURE = 0.99
"""Largest share of right runs that is asked of a fixed number. Chosen: more takes too many
simulated runs."""

Draw = Callable[[np.random.Generator, int, int], np.ndarray]
"""Generator, runs and starts -> which experiments commuted: bool (runs, starts, dofs)."""


class Case(NamedTuple):
    """Where runs are simulated.

    Attributes
    ----------
    name : str
    scp : float (dofs,)
        The true SCPs.
    draw : callable
    """

    name: str
    scp: np.ndarray
    draw: Draw


def bernoulli_case(name: str, scp: np.ndarray) -> Case:
    """Independent degrees of freedom with these SCPs."""
    return Case(name, scp, lambda rng, runs, starts: rng.random((runs, starts, len(scp))) < scp)


def recorded_case(name: str, commuted: np.ndarray) -> Case:
    """Recorded starts, bool (n, dofs), drawn with replacement."""

    def draw(rng: np.random.Generator, runs: int, starts: int) -> np.ndarray:
        return commuted[rng.integers(len(commuted), size=(runs, starts))]

    return Case(name, commuted.mean(axis=0), draw)


class Simulated(NamedTuple):
    """Runs of one case.

    Attributes
    ----------
    relations : int (runs, pairs)
        What was said of each pair.
    units : int (runs, dofs)
        Experiments of each degree of freedom.
    """

    relations: np.ndarray
    units: np.ndarray
    pairs: list[tuple[int, int]]


def simulate(case: Case, settings: SequentialConfig, rng: np.random.Generator) -> Simulated:
    """Play settings.runs runs until everything is decided, or for settings.largest starts."""
    test = SequentialOrder(len(case.scp), settings.alpha, settings.margin, settings.runs)
    for _ in range(settings.largest // LOOK):
        test.update(case.draw(rng, settings.runs, LOOK))
        if not test.active.any():
            break
    return Simulated(test.relations, test.units, test.pairs)


def wrong_runs(
    relations: np.ndarray, pairs: list[tuple[int, int]], scp: np.ndarray, margin: float
) -> np.ndarray:
    """Which runs said anything that is wrong: bool (runs,)."""
    wrong = np.zeros(len(relations), bool)
    for k, (i, j) in enumerate(pairs):
        difference = scp[i] - scp[j]
        wrong |= (relations[:, k] == HIGHER) & (difference <= 0)
        wrong |= (relations[:, k] == LOWER) & (difference >= 0)
        wrong |= (relations[:, k] == TIED) & (abs(difference) >= margin - 1e-12)
    return wrong


def right_runs(
    relations: np.ndarray, pairs: list[tuple[int, int]], scp: np.ndarray, margin: float
) -> np.ndarray:
    """Which runs decided every pair, and rightly: bool (runs,)."""
    return (relations != UNDECIDED).all(axis=1) & ~wrong_runs(relations, pairs, scp, margin)


def fixed_number(
    case: Case, settings: SequentialConfig, power: float, rng: np.random.Generator
) -> int:
    """Least number of starts with which the same is decided, as certainly.

    Every pair is put in its order (McNemar's test), or found tied if it differs by less than the
    margin (the interval of the difference lies within the margin), in a share `power` of the runs;
    at the same levels as the sequential tests. At most ten times settings.largest, which is
    returned if no number suffices.
    """
    low, high = LOOK, 10 * settings.largest
    while low < high:
        middle = (low + high) // 2
        if _power(case, settings, middle, rng) >= power:
            high = middle
        else:
            low = middle + 1
    return low


FIXED_RUNS = 300
"""Simulated runs of each fixed number. Chosen."""


def _power(case: Case, settings: SequentialConfig, n: int, rng: np.random.Generator) -> float:
    from scipy import stats

    first, second = np.array(SequentialOrder(len(case.scp)).pairs).T
    truth = case.scp[first] - case.scp[second]
    near = np.abs(truth) < settings.margin - 1e-12
    order_level, tie_level = pair_levels(settings.alpha, len(truth))
    right = 0
    for _ in range(FIXED_RUNS):
        commuted = case.draw(rng, 1, n)[0]
        a, b = commuted[:, first], commuted[:, second]
        only_a, only_b = (a & ~b).sum(axis=0), (~a & b).sum(axis=0)
        both = only_a + only_b
        p = np.minimum(1, 2 * stats.binom.cdf(np.minimum(only_a, only_b), both, 0.5))
        ordered = (p <= order_level) & (np.sign(only_a - only_b) == np.sign(truth))
        # The interval of paired.paired_difference_interval, for all pairs at once.
        z = stats.norm.isf(tie_level)
        x, y = only_a + 0.5, only_b + 0.5
        difference = (x - y) / (n + 2)
        half = z * np.sqrt(x + y - (x - y) ** 2 / (n + 2)) / (n + 2)
        tied = np.abs(difference) + half < settings.margin
        right += bool((ordered | (tied & near)).all())
    return right / FIXED_RUNS


@table(
    title="Sampling until the order is decided",
    columns=(
        Column("case", TEXT, "", "equal, margin, or a world whose trials are resampled", key=True),
        Column("protocol", TEXT, "", "reset or return; of simulated cases: none", key=True),
        Column("runs", INT, "1", "simulated runs"),
        Column("error", FLOAT, "1", "share of runs in which anything said was wrong"),
        Column("error_high", FLOAT, "1", "upper end of its one-sided 97.5 % interval"),
        Column("level", FLOAT, "1", "largest error that is allowed"),
        Column("decided", FLOAT, "1", "mean share of pairs that were ordered or found tied"),
        Column("tied", FLOAT, "1", "mean share of pairs that were found tied"),
        Column("starts", FLOAT, "1", "mean number of starts"),
        Column("experiments", FLOAT, "1", "mean number of experiments, all degrees of freedom"),
        Column("right", FLOAT, "1", "share of runs that decided every pair, and rightly"),
        Column(
            "fixed_experiments", FLOAT, "1",
            "experiments that a fixed number of starts needs to be right as often, or in .99",
            nullable=True,
        ),
        Column("share", FLOAT, "1", "experiments over fixed_experiments", nullable=True),
        Column(
            "fixed_at_power", FLOAT, "1", "the same, to be right in reset_free.sequential.power",
            nullable=True,
        ),
    ),
    inputs=["reset_free_trials"],
    settings=lambda config: reset_free(config).sequential,
)  # fmt: skip
def reset_free_sequential(trials: pd.DataFrame, config: Config) -> pd.DataFrame:
    """All cases."""
    from ....statistics.proportions import wilson_interval

    settings = reset_free(config).sequential
    rows = []
    for protocol, case in _cases(trials, settings):
        rng = generator(config.seed, "sequential", case.name, protocol)
        found = simulate(case, settings, rng)
        wrong = wrong_runs(found.relations, found.pairs, case.scp, settings.margin)
        right = right_runs(found.relations, found.pairs, case.scp, settings.margin).mean()
        fixed = at_power = np.nan
        if protocol != "none":
            n = len(case.scp)
            fixed = float(n * fixed_number(case, settings, min(right, SURE), rng))
            at_power = float(n * fixed_number(case, settings, settings.power, rng))
        experiments = float(found.units.sum(axis=1).mean())
        rows.append(
            (case.name, protocol, settings.runs, float(wrong.mean()),
             float(wilson_interval(int(wrong.sum()), settings.runs)[1]), settings.alpha,
             float((found.relations != UNDECIDED).mean()), float((found.relations == TIED).mean()),
             float(found.units.max(axis=1).mean()), experiments, float(right), fixed,
             experiments / fixed, at_power)
        )  # fmt: skip
    return pd.DataFrame(rows, columns=reset_free_sequential.column_names)


def _cases(trials: pd.DataFrame, settings: SequentialConfig) -> list[tuple[str, Case]]:
    n = len(DOFS)
    steps = EQUAL + settings.margin * (np.arange(n) % 2 - 0.5)
    cases = [
        ("none", bernoulli_case("equal", np.full(n, EQUAL))),
        ("none", bernoulli_case("margin", steps)),
    ]
    for world, group in trials.groupby("world", sort=False):
        if not shares_starts(group):
            continue  # degrees of freedom are compared at the same starts
        for protocol, column in (("reset", "reset"), ("return", "distance")):
            wide = group.pivot(index="experiment", columns="dof", values=column)[list(DOFS)]
            cases.append((protocol, recorded_case(str(world), (wide == 0).to_numpy())))
    return cases
