"""A/A tests of Welch's test."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy.stats import binom
from statsmodels.stats.weightstats import ttest_ind

from sensory_commutativity.statistics.calibration import (
    binomial_band,
    count_resampled_rejections,
    count_split_rejections,
)
from sensory_commutativity.statistics.groups import welch

pytestmark = pytest.mark.filterwarnings("error")


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


# ---- random halves -------------------------------------------------------------------------------


def test_splits_are_random_halves():
    """Against the rate over all ways to split the values into halves."""
    for n, seed in ((8, 0), (9, 2)):
        values = rng(seed).exponential(1, n)
        p = [
            ttest_ind(values[list(i)], np.delete(values, i), usevar="unequal")[1]
            for i in combinations(range(n), n // 2)
        ]
        for alpha, tolerance in ((0.05, 0.01), (0.3, 0.02)):
            expected = np.mean(np.array(p) < alpha)
            assert 0 < expected < 0.5
            rate = count_split_rejections(values, 4000, alpha, rng()) / 4000
            assert rate == pytest.approx(expected, abs=tolerance), (n, alpha)


def test_splits_of_normal_values_keep_the_level():
    rejections = count_split_rejections(rng(1).normal(3, 2, 30), 4000, 0.05, rng())
    assert 0.03 < rejections / 4000 < 0.07


def test_variances_are_not_pooled():
    """For 10, 30 against 0, 1, 2, Student's p is 0.085 and Welch's 0.31; no halves have p < 0.2."""
    values = np.array([0.0, 1, 2, 10, 30])
    halves = [(values[list(i)], np.delete(values, i)) for i in combinations(range(5), 2)]
    assert min(ttest_ind(*pair, usevar="pooled")[1] for pair in halves) < 0.1
    assert min(welch(*pair).p for pair in halves) > 0.2
    assert count_split_rejections(values, 500, 0.2, rng()) == 0


def test_equal_values_are_never_rejected():
    for n in (7, 30):  # the rounded means of three and of four 0.1 differ
        assert count_split_rejections([0.1] * n, 500, 0.99, rng()) == 0
        assert count_resampled_rejections([0.1] * n, 500, 0.05, rng()) == 0


def test_constant_halves_that_differ_are_rejected():
    """Of six ways to halve 0, 0, 1, 1, two have constant halves (p 0), the others p 1."""
    rate = count_split_rejections([0, 0, 1, 1], 3000, 0.001, rng()) / 3000
    assert rate == pytest.approx(1 / 3, abs=0.03)


def test_values_are_not_changed_and_equal_generators_agree():
    values = rng(2).normal(0, 1, 12)
    before = values.copy()
    counts = [count_split_rejections(values, 300, 0.3, rng(4)) for _ in range(2)]
    assert counts[0] == counts[1]
    assert (values == before).all()


# ---- draws with replacement ----------------------------------------------------------------------


def test_resampled_groups_of_normal_values_reject_at_the_level():
    """Welch's test is exact for normal values, nearly so for their empirical distribution."""
    low, high = binomial_band(0.05, 20_000, confidence=0.9999)
    rate = count_resampled_rejections(rng().normal(size=60), 20_000, 0.05, rng(1)) / 20_000
    assert low - 0.003 < rate < high + 0.003


def test_resampled_groups_have_all_values_and_are_independent():
    """With two distinct values, the rate follows from binomial numbers of the larger one."""
    values, n = np.array([0.0, 0.0, 0.0, 1.0, 1.0]), 5
    groups = [np.repeat([0.0, 1.0], [n - k, k]) for k in range(n + 1)]
    probability = binom.pmf(range(n + 1), n, 0.4)
    expected = sum(
        probability[a] * probability[b] * (welch(groups[a], groups[b]).p < 0.2)
        for a in range(n + 1)
        for b in range(n + 1)
    )
    rate = count_resampled_rejections(values, 40_000, 0.2, rng()) / 40_000
    assert rate == pytest.approx(expected, abs=0.01)


# ---- binomial band and invalid arguments ---------------------------------------------------------


def test_binomial_band():
    for alpha, n, confidence in ((0.05, 2000, 0.95), (0.3, 50, 0.8), (0.001, 100, 0.99)):
        low, high = binomial_band(alpha, n, confidence)
        rates = rng().binomial(n, alpha, 20_000) / n
        tail = (1 - confidence) / 2
        assert (rates < low).mean() <= tail + 0.005
        assert (rates > high).mean() <= tail + 0.005
        assert low == 0 or (rates <= low).mean() >= tail - 0.005
        assert (rates >= high).mean() >= tail - 0.005


def test_binomial_band_by_hand():
    """1 in 16 throws of four coins shows no head, which is more than 2.5 % and less than 10 %."""
    assert binomial_band(0.5, 4) == (0, 1)
    assert binomial_band(0.5, 4, 0.8) == (0.25, 0.75)


def test_invalid_arguments_are_rejected():
    for count in (count_split_rejections, count_resampled_rejections):
        with pytest.raises(ValueError, match="at least 4"):
            count([1, 2, 3], 9, 0.05, rng())
        with pytest.raises(ValueError, match="not finite"):
            count([1, 2, 3, np.nan], 9, 0.05, rng())
        with pytest.raises(ValueError, match="alpha must lie between 0 and 1"):
            count([1, 2, 3, 4], 9, 5, rng())
    with pytest.raises(ValueError, match="alpha must lie between 0 and 1"):
        binomial_band(5, 100)
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        binomial_band(0.05, 100, 95)
