"""statistics/calibration.py: A/A tests."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy.stats import binom
from statsmodels.stats.weightstats import ttest_ind

from sensory_commutativity.statistics.calibration import (
    binomial_band,
    resampled_rejections,
    split_rejections,
)
from sensory_commutativity.statistics.groups import welch

pytestmark = pytest.mark.filterwarnings("error")


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize(("n", "seed"), [(8, 0), (9, 2)])
@pytest.mark.parametrize("alpha", [0.05, 0.3])
def test_rejections_are_those_of_random_halves(n, seed, alpha):
    """Against the share among all ways to cut the values in two."""
    values = rng(seed).exponential(1, n)
    p = [
        ttest_ind(values[list(i)], np.delete(values, i), usevar="unequal")[1]
        for i in combinations(range(n), n // 2)
    ]
    share = np.mean(np.array(p) < alpha)
    assert 0 < share < 0.5
    assert split_rejections(values, 4000, alpha, rng()) / 4000 == pytest.approx(
        share, abs=0.02 if alpha > 0.1 else 0.01
    )


def test_the_level_is_kept():
    rejected = split_rejections(rng(1).normal(3, 2, 30), 4000, 0.05, rng())
    assert 0.03 < rejected / 4000 < 0.07


def test_variances_are_not_pooled():
    """Against 0, 1 and 2, Student's test tells 10 and 30 apart (p = 0.085), Welch's does not (p = 0.31), nor any other halves at 0.2."""
    values = np.array([0.0, 1, 2, 10, 30])
    halves = [(values[list(i)], np.delete(values, i)) for i in combinations(range(5), 2)]
    assert min(ttest_ind(*pair, usevar="pooled")[1] for pair in halves) < 0.1
    assert min(welch(*pair).p for pair in halves) > 0.2
    assert split_rejections(values, 500, 0.2, rng()) == 0


def test_equal_values_are_never_rejected():
    assert (
        split_rejections([0.1] * 7, 500, 0.99, rng()) == 0
    )  # rounded means of three and of four differ
    assert split_rejections([0.3] * 30, 500, 0.99, rng()) == 0


def test_constant_halves():
    """Of the six ways to halve 0, 0, 1, 1, two have constant halves that differ: p 0. The others have equal means: p 1."""
    assert split_rejections([0, 0, 1, 1], 3000, 0.001, rng()) / 3000 == pytest.approx(
        1 / 3, abs=0.03
    )


def test_values_are_left_alone_and_equal_generators_agree():
    values = rng(2).normal(0, 1, 12)
    before = values.copy()
    assert split_rejections(values, 300, 0.3, rng(4)) == split_rejections(values, 300, 0.3, rng(4))
    assert (values == before).all()


@pytest.mark.parametrize(
    ("alpha", "n", "confidence"), [(0.05, 2000, 0.95), (0.3, 50, 0.8), (0.001, 100, 0.99)]
)
def test_binomial_band(alpha, n, confidence):
    low, high = binomial_band(alpha, n, confidence)
    rates = rng().binomial(n, alpha, 20_000) / n
    assert (rates < low).mean() <= (1 - confidence) / 2 + 0.005
    assert (rates > high).mean() <= (1 - confidence) / 2 + 0.005
    assert low == 0 or (rates <= low).mean() >= (1 - confidence) / 2 - 0.005
    assert (rates >= high).mean() >= (1 - confidence) / 2 - 0.005


def test_binomial_band_by_hand():
    """Four coins: 1 in 16 shows no head, which is more than 2.5 % and less than 10 %."""
    assert binomial_band(0.5, 4) == (0, 1)
    assert binomial_band(0.5, 4, 0.8) == (0.25, 0.75)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: split_rejections([1, 2, 3], 9, 0.05, rng()), "at least 4"),
        (lambda: split_rejections([1, 2, 3, np.nan], 9, 0.05, rng()), "not finite"),
        (lambda: split_rejections([1, 2, 3, 4], 9, 5, rng()), "alpha must lie between 0 and 1"),
        (lambda: binomial_band(5, 100), "alpha must lie between 0 and 1"),
        (lambda: binomial_band(0.05, 100, 95), "confidence must lie between 0 and 1"),
    ],
)
def test_what_is_refused(call, says):
    with pytest.raises(ValueError, match=says):
        call()


def test_resampled_groups_of_normal_values_reject_at_the_level():
    """Welch's test is right for normal values, nearly so for their empirical distribution."""
    values = np.random.default_rng(0).normal(size=60)
    low, high = binomial_band(0.05, 20_000, confidence=0.9999)
    assert (
        low - 0.003
        < resampled_rejections(values, 20_000, 0.05, np.random.default_rng(1)) / 20_000
        < high + 0.003
    )


def test_resampled_groups_are_as_large_as_the_values_and_independent():
    """Of two values, a group of n holds a binomial number of the larger one: the rate follows from all pairs of such numbers."""
    values, n = np.array([0.0, 0.0, 0.0, 1.0, 1.0]), 5
    groups = [np.repeat([0.0, 1.0], [n - k, k]) for k in range(n + 1)]
    chance = binom.pmf(range(n + 1), n, 0.4)
    expected = sum(
        chance[a] * chance[b] * (welch(groups[a], groups[b]).p < 0.2)
        for a in range(n + 1)
        for b in range(n + 1)
    )
    assert resampled_rejections(values, 40_000, 0.2, rng()) / 40_000 == pytest.approx(
        expected, abs=0.01
    )


def test_resampled_equal_values_are_never_rejected():
    assert resampled_rejections(np.full(6, 0.1), 500, 0.05, np.random.default_rng(0)) == 0
