"""Simulated coverage of every type of interval that the tables have.

A simulation draws data whose truth is known, computes the interval as the tables do, and counts how
often it holds the truth. Sizes are those of the studies, or smaller.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cache, partial

import numpy as np
import pandas as pd

from .cases import ENDS, MIDDLE, Case

N = 400
"""Experiments per degree of freedom, as in the apartment."""
RUNS = 60
"""Training runs of an action space."""
RESAMPLES = 999
"""Of bootstraps, of which the tables draw 9,999; chosen: the ends of the intervals are as good."""
FEW = 400
"""Repeats where an interval takes long; chosen: the standard error of a coverage is .011."""
PROPORTIONS = (0.005, 0.02, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95, 0.98, 0.995)
PAIRS = ((0.995, 1.0), (0.99, 1.0), (0.98, 0.99), (0.9, 0.95), (0.5, 0.6), (0.5, 0.5), (0.05, 0.1))
"""SCPs of two degrees of freedom, measured from the same starts, and independent given these."""


def interval_cases() -> Iterator[Case]:
    """All simulations of intervals."""
    for p in PROPORTIONS:
        band = MIDDLE if 0.02 <= p <= 0.98 else ENDS
        yield Case("Wilson, proportion", p, N, band, 10_000, partial(wilson, p))
    for a, b in PAIRS:
        band = MIDDLE if max(a, b) <= 0.98 else ENDS
        name = f"Tango, paired difference of {a:g} and {b:g}"
        yield Case(name, a - b, N, band, 4_000, partial(tango, a, b))
    yield Case("Student, mean of paired differences", 0.3, RUNS, MIDDLE, 4_000, student)
    yield Case("Welch, difference of means, unequal variances", 1.0, RUNS, MIDDLE, 4_000, welch)
    yield Case("percentile bootstrap, ratio of means", 0.4, RUNS, MIDDLE, FEW, ratio)
    yield Case("bootstrap, mean", 1.0, RUNS, MIDDLE, FEW, partial(summary, "mean"))
    yield Case("bootstrap, median", math.log(2), RUNS, MIDDLE, FEW, partial(summary, "median"))
    yield Case("bootstrap, probability of improvement", 0.5, RUNS, MIDDLE, FEW, improvement)
    yield Case("cluster bootstrap, mean over scenes", 0.8, 40, MIDDLE, 2_000, clusters)
    yield Case("Student over scenes, paired difference", 0.1, 40, MIDDLE, 2_000, paired_clusters)
    yield Case("Kaplan-Meier, survival", 0.5, RUNS, MIDDLE, 2_000, survival)
    yield Case("paired bootstrap, Kendall's tau", 5 / 7, N, ENDS, FEW // 2, kendall)


def wilson(p: float, rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.proportions import wilson_interval

    low, high = wilson_interval(rng.binomial(N, p, repeats), np.full(repeats, N))
    return int(((low <= p) & (p <= high)).sum())


def tango(a: float, b: float, rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.paired import paired_difference_interval

    interval = cache(paired_difference_interval)
    cells = rng.multinomial(N, [a * b, a * (1 - b), b * (1 - a), (1 - a) * (1 - b)], repeats)
    ends = (interval(int(only_a), int(only_b), N) for _, only_a, only_b, _ in cells)
    return sum(low - 1e-12 <= a - b <= high + 1e-12 for low, high in ends)


def student(rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.paired import paired_means

    ends = (paired_means(rng.normal(0.3, 1, RUNS))[:2] for _ in range(repeats))
    return sum(low <= 0.3 <= high for low, high in ends)


def welch(rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.groups import welch as compare

    tests = (compare(rng.normal(1, 3, RUNS), rng.normal(0, 1, RUNS)) for _ in range(repeats))
    return sum(test.ci_low <= 1 <= test.ci_high for test in tests)


def ratio(rng: np.random.Generator, repeats: int) -> int:
    """Steps to a threshold, which are about exponential."""
    from ...statistics.aggregates import ratio_of_means

    inside = 0
    for _ in range(repeats):
        found = ratio_of_means(rng.exponential(0.4, RUNS), rng.exponential(1, RUNS), rng, RESAMPLES)
        inside += found.ci_low <= 0.4 <= found.ci_high
    return inside


def summary(which: str, rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.aggregates import bootstrap_interval

    truth = {"mean": 1.0, "median": math.log(2)}[which]
    statistic: Callable[..., float] = {"mean": np.mean, "median": np.median}[which]  # type: ignore[assignment]
    inside = 0
    for _ in range(repeats):
        low, high = bootstrap_interval(rng.exponential(1, RUNS), statistic, rng, RESAMPLES)
        inside += low <= truth <= high
    return inside


def improvement(rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.groups import probability_of_improvement

    inside = 0
    for _ in range(repeats):
        found = probability_of_improvement(rng.normal(size=RUNS), rng.normal(size=RUNS), rng,
                                           RESAMPLES)  # fmt: skip
        inside += found.ci_low <= 0.5 <= found.ci_high
    return inside


def clusters(rng: np.random.Generator, repeats: int) -> int:
    """Correct outcomes of ten tuples in each of 40 scenes, which differ from each other."""
    from ...statistics.aggregates import percentile_interval
    from ...statistics.clusters import cluster_means, resample_clusters

    labels, inside = pd.Series(np.repeat(np.arange(40), 10)), 0
    for _ in range(repeats):
        of_scene = rng.beta(8, 2, 40)  # mean 0.8
        correct = (rng.random(400) < of_scene[labels]).astype(float)
        means = cluster_means(correct, *resample_clusters(labels, RESAMPLES, rng))
        low, high = percentile_interval(means, 0.95)
        inside += low <= 0.8 <= high
    return inside


def paired_clusters(rng: np.random.Generator, repeats: int) -> int:
    from ...statistics.clusters import paired_cluster_difference

    labels, inside = pd.Series(np.repeat(np.arange(40), 10)), 0
    for _ in range(repeats):
        difference = rng.normal(0.1, 0.3, 40)[labels] + rng.normal(0, 1, 400)
        found = paired_cluster_difference(difference, labels)
        inside += found.ci_low <= 0.1 <= found.ci_high
    return inside


def survival(rng: np.random.Generator, repeats: int) -> int:
    """Half of the runs reach the threshold within the median time; some are censored before."""
    from ...statistics.survival import kaplan_meier

    inside = 0
    for _ in range(repeats):
        times, ends = rng.exponential(1 / math.log(2), RUNS), rng.uniform(0.5, 3, RUNS)
        curve = kaplan_meier(np.minimum(times, ends), times <= ends)
        last = np.searchsorted(curve.time, 1.0, side="right") - 1
        if last >= 0:
            inside += curve.ci_low[last] <= 0.5 <= curve.ci_high[last]
    return inside


def kendall(rng: np.random.Generator, repeats: int) -> int:
    """Two conditions that rank eight degrees of freedom alike but for four pairs of neighbours.

    Tau takes few values, so that its interval covers more than 95 %.
    """
    from ...statistics.orders import order_agreement

    first = np.linspace(0.15, 0.95, 8)
    second = first[[1, 0, 3, 2, 5, 4, 7, 6]]
    inside = 0
    for _ in range(repeats):
        uniform = rng.random((N, 8))
        found = order_agreement(uniform < first, uniform < second, rng, paired=True, resamples=299)
        inside += found.ci_low - 1e-9 <= 5 / 7 <= found.ci_high + 1e-9
    return inside
