"""A/A: how often every test rejects where nothing differs.

An exact test of counts rejects at most as often as its level says, and often less; all others
should reject as often.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from .cases import Case
from .intervals import RUNS, N

ALPHA = 0.05
REPEATS = 4_000
FEW = 1_000
EXACT, ABOUT = (0.0, ALPHA), (ALPHA, ALPHA)
"""Bands of the rate; the simulation's own error comes on top."""


def level_cases() -> Iterator[Case]:
    """All simulations of tests."""
    for p in (0.5, 0.9, 0.99):
        name = f"McNemar, exact, SCPs of {p:g}"
        yield Case(name, ALPHA, N, EXACT, REPEATS, partial(mcnemar, p))
    yield Case("equivalence, at the margin of 0.02", ALPHA, N * 25, EXACT, REPEATS, equivalence)
    yield Case("Cochran-Armitage, trend", ALPHA, N, ABOUT, REPEATS, trend)
    yield Case("Cochran-Mantel-Haenszel", ALPHA, N, ABOUT, FEW, strata)
    yield Case("Welch", ALPHA, RUNS, ABOUT, REPEATS, partial(groups, "welch"))
    yield Case("Mann-Whitney", ALPHA, RUNS, ABOUT, REPEATS, partial(groups, "mann_whitney"))
    yield Case("permutation", ALPHA, RUNS, ABOUT, FEW, permutation)
    yield Case("Student, paired", ALPHA, RUNS, ABOUT, REPEATS, paired)
    for alpha in (0.05, 0.025):
        name = f"log-rank at {alpha:g}"
        yield Case(name, alpha, RUNS, (alpha, alpha), REPEATS, partial(log_rank, alpha))
    yield Case("Spearman, permutation", ALPHA, 8, EXACT, 300, spearman)


def mcnemar(p: float, rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.paired import sign_test

    cells = rng.multinomial(N, [p * p, p * (1 - p), p * (1 - p), (1 - p) ** 2], repeats)
    return sum(sign_test(int(a), int(a + b)) < ALPHA for _, a, b, _ in cells)


def equivalence(rng: np.random.Generator, repeats: int) -> int:
    """Two SCPs that differ by the margin, which the test must not call equal."""
    from ...statistics.paired import equivalence_test

    n = N * 25
    cells = rng.multinomial(n, [0.85, 0.05, 0.03, 0.07], repeats)
    return sum(equivalence_test(int(a), int(b), n, 0.02) < ALPHA for _, a, b, _ in cells)


def trend(rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.trends import cochran_armitage

    n, scores = np.full(4, N), [0, 4, 8, 12]
    return sum(cochran_armitage(k, n, scores).p < ALPHA for k in rng.binomial(N, 0.9, (repeats, 4)))


def strata(rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.trends import mantel_haenszel

    n, p = np.full(4, N), np.array([0.7, 0.8, 0.9, 0.95])
    drawn = rng.binomial(N, p, (repeats, 2, 4))
    return sum(mantel_haenszel(a, n, b, n).p < ALPHA for a, b in drawn)


def groups(which: str, rng: np.random.Generator, repeats: int) -> int:
    from ...statistics import groups as tests

    test = getattr(tests, which)
    drawn = rng.normal(size=(repeats, 2, RUNS))
    return sum(test(a, b).p < ALPHA for a, b in drawn)


def permutation(rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.groups import permutation_test

    drawn = rng.exponential(size=(repeats, 2, RUNS))
    return sum(permutation_test(a, b, rng, 999) < ALPHA for a, b in drawn)


def paired(rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.paired import paired_means

    return sum(paired_means(x)[2] < ALPHA for x in rng.normal(size=(repeats, RUNS)))


def log_rank(alpha: float, rng: np.random.Generator, repeats: int) -> int:
    """Steps in whole segments of a run, censored at its end, as those of the studies are."""
    from ...statistics.survival import log_rank as test

    rejected = 0
    for _ in range(repeats):
        times = np.ceil(rng.exponential(8, (2, RUNS)))
        reached = times <= 20
        (x, y), (seen_x, seen_y) = np.minimum(times, 20), reached
        rejected += test(x, seen_x, y, seen_y).p < alpha
    return rejected


def spearman(rng: np.random.Generator, repeats: int) -> int:
    """Eight degrees of freedom, as in the table flatland_alternatives."""
    from ...statistics.ranks import rank_correlation

    drawn = rng.normal(size=(repeats, 2, 8))
    return sum(rank_correlation(x, y, rng, 199).p < ALPHA for x, y in drawn)
