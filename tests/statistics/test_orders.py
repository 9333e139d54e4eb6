"""Kendall's tau of two rankings and its bootstrap interval."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kendalltau

from sensory_commutativity.statistics.orders import order_agreement

P = np.array([0.1, 0.3, 0.5, 0.7, 0.9])


def draw(p: np.ndarray, n: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).random((n, len(p))) < p


def test_tau_is_that_of_the_column_means():
    a, b = draw(P, 40, 0), draw(P[[0, 2, 1, 4, 3]], 40, 1)
    result = order_agreement(a, b, np.random.default_rng(0), paired=False)
    assert result.tau == pytest.approx(kendalltau(a.mean(0), b.mean(0)).statistic)
    assert result.ci_low <= result.tau <= result.ci_high <= 1


def test_equal_and_reversed_order():
    a = draw(P, 2000, 0)
    equal = order_agreement(a, a, np.random.default_rng(0), paired=True)
    assert equal[:2] == pytest.approx((1, 1))
    reverse = order_agreement(a, draw(P[::-1], 2000, 1), np.random.default_rng(0), paired=False)
    assert reverse.tau == pytest.approx(-1) and reverse.ci_high < -0.9


def test_pairing_narrows_the_interval_of_shared_units():
    """Two identical measurements agree in every resample of shared units, but not otherwise."""
    a = draw(np.array([0.5, 0.52, 0.54]), 200, 3)
    together, apart = (
        order_agreement(a, a, np.random.default_rng(1), paired=paired) for paired in (True, False)
    )
    assert together.ci_low == pytest.approx(1) and apart.ci_low < 0.9


def test_ties_have_no_order():
    ties = np.ones((10, 4))
    result = order_agreement(ties, draw(P[:4], 10, 0), np.random.default_rng(0), paired=False)
    assert all(np.isnan(result))


def test_interval_covers_the_true_order():
    """Both samples have the same true order, tau 1; 95 % intervals of it nearly always hold 1."""
    covered = 0
    for seed in range(40):
        a, b, rng = draw(P, 60, 2 * seed), draw(P, 60, 2 * seed + 1), np.random.default_rng(seed)
        covered += order_agreement(a, b, rng, paired=False, resamples=200).ci_high >= 0.999
    assert covered >= 34


def test_different_items_are_rejected():
    for shape, paired in (((5, 3), False), ((4, 4), True), ((5,), False)):
        with pytest.raises(ValueError, match="same items"):
            order_agreement(np.zeros((5, 4)), np.zeros(shape), np.random.default_rng(0), paired)
