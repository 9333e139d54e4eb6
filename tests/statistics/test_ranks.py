"""Rank correlation with a permutation test."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import kendalltau, spearmanr

from sensory_commutativity.statistics.ranks import rank_correlation


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def test_equal_and_opposite_order():
    equal = rank_correlation(np.arange(8.0), np.arange(8.0) ** 3, rng(), 500)
    assert (equal.n, equal.p) == (8, 1 / 501)  # only 2 of 40,320 orders are as extreme
    assert (equal.spearman, equal.kendall) == pytest.approx((1.0, 1.0))
    opposite = rank_correlation(np.arange(8.0), -np.arange(8.0), rng(), 200)
    assert (opposite.spearman, opposite.kendall) == pytest.approx((-1.0, -1.0))
    assert opposite.p == 1 / 201


def test_by_hand():
    """Ranks 1 2 3 4 5 and 2 1 4 3 5: squared differences sum to 4; 2 of 10 pairs discordant."""
    x, y = np.array([1.0, 2, 3, 4, 5]), np.array([20.0, 10, 40, 30, 50])
    result = rank_correlation(x, y, rng(), 50)
    assert result.spearman == pytest.approx(1 - 6 * 4 / (5 * 24))
    assert result.kendall == pytest.approx((8 - 2) / 10)


def test_p_approaches_the_exact_value():
    """Of the 6 orders of three items, 2 have abs(rho) = 1 and all have abs(rho) >= 1/2."""
    x = np.arange(3.0)
    assert rank_correlation(x, x, rng(), 1000).p == pytest.approx(1 / 3, abs=0.05)
    assert rank_correlation(x, np.array([0.0, 2, 1]), rng(), 200).p == 1.0


def test_ties_agree_with_scipy():
    x, y = np.array([0.0, 0, 1, 2, 2, 3, 4, 4]), np.array([1.0, 0, 0, 2, 5, 5, 5, 3])
    result = rank_correlation(x, y, rng(), 50)
    assert result.spearman == pytest.approx(spearmanr(x, y).statistic)
    assert result.kendall == pytest.approx(kendalltau(x, y, variant="b").statistic)


def test_constants_have_no_order():
    for x, y in (([1, 1, 1], [1, 2, 3]), ([1, 2, 3], [0, 0, 0])):
        result = rank_correlation(np.array(x), np.array(y), rng(), 10)
        assert (result.n, result.p) == (3, 1.0)
        assert math.isnan(result.spearman) and math.isnan(result.kendall)


def test_p_depends_on_the_generator_alone():
    x, y = np.arange(6.0), np.array([1.0, 0, 3, 2, 5, 4])
    p = [rank_correlation(x, y, np.random.default_rng(seed), 100).p for seed in (1, 1, 2, 3)]
    assert p[0] == p[1]
    assert len(set(p)) > 1


def test_p_keeps_its_level_for_independent_measures():
    random = np.random.default_rng(5)
    p = np.array(
        [rank_correlation(random.random(8), random.random(8), random, 19).p for _ in range(120)]
    )
    assert 0.3 < np.mean(p <= 0.5) < 0.68
    assert np.mean(p <= 0.05) < 0.12  # p is at least 1/20
