"""Comparisons of two or more independent groups of runs."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from statsmodels.stats.meta_analysis import effectsize_smd
from statsmodels.stats.weightstats import CompareMeans, DescrStatsW

from sensory_commutativity.statistics.groups import (
    games_howell,
    mann_whitney,
    permutation_test,
    probability_of_improvement,
    welch,
)

pytestmark = pytest.mark.filterwarnings("error")

A, B = np.array([3.0, 4.0, 5.0, 8.0]), np.array([1.0, 2.0, 3.0])


def normal(seed: int, n: int, mean: float = 0.0, sd: float = 1.0) -> np.ndarray:
    return np.random.default_rng(seed).normal(mean, sd, n)


# ---- Welch ---------------------------------------------------------------------------------------


def test_welch_by_hand():
    """Means 5 and 2, variances 14/3 and 1: squared standard errors 7/6 and 1/3."""
    result = welch(A, B)
    error = math.sqrt(7 / 6 + 1 / 3)
    df = (7 / 6 + 1 / 3) ** 2 / ((7 / 6) ** 2 / 3 + (1 / 3) ** 2 / 2)
    half = stats.t.ppf(0.975, df) * error
    assert result.difference == 3
    assert (result.statistic, result.df) == pytest.approx((3 / error, df))
    assert result.p == pytest.approx(2 * stats.t.sf(3 / error, df))
    assert (result.ci_low, result.ci_high) == pytest.approx((3 - half, 3 + half))
    g = 3 / math.sqrt((3 * 14 / 3 + 2 * 1) / 5) * (1 - 3 / 19)
    assert result.effect_size == pytest.approx(g)


def test_welch_agrees_with_statsmodels():
    for n, m, sd, confidence in ((30, 30, 1, 0.95), (12, 40, 5, 0.99), (2, 3, 0.1, 0.5)):
        a, b = normal(1, n, 2, sd), normal(2, m)
        result, expected = welch(a, b, confidence), CompareMeans(DescrStatsW(a), DescrStatsW(b))
        test = expected.ttest_ind(usevar="unequal")
        assert (result.statistic, result.p, result.df) == pytest.approx(test), (n, m)
        interval = expected.tconfint_diff(alpha=1 - confidence, usevar="unequal")
        assert (result.ci_low, result.ci_high) == pytest.approx(interval), (n, m)
        g = effectsize_smd(a.mean(), a.std(ddof=1), n, b.mean(), b.std(ddof=1), m)[0]
        assert result.effect_size == pytest.approx(g), (n, m)


@given(st.integers(0, 1000), st.integers(2, 20), st.integers(2, 20))
@settings(max_examples=25, deadline=None)
def test_welch_is_antisymmetric(seed, n, m):
    a, b = normal(seed, n), normal(seed + 1, m, 1)
    ab, ba = welch(a, b), welch(b, a)
    assert (ba.p, ba.df) == pytest.approx((ab.p, ab.df))
    assert (ba.statistic, ba.difference) == pytest.approx((-ab.statistic, -ab.difference))
    assert ba.effect_size == pytest.approx(-ab.effect_size)
    assert (ba.ci_low, ba.ci_high) == pytest.approx((-ab.ci_high, -ab.ci_low))
    assert ab.ci_low < ab.difference < ab.ci_high


def test_welch_of_constant_groups():
    assert welch([0.1] * 3, [0.1] * 7) == (0, 8, 1, 0, 0, 0, 0)  # the mean of seven 0.1 is not 0.1
    assert welch([2, 2], [1, 1, 1]) == (math.inf, 3, 0, 1, 1, 1, math.inf)
    assert welch([1, 1, 1], [3, 3]) == (-math.inf, 3, 0, -2, -2, -2, -math.inf)
    one_constant = welch([1, 1, 1, 1], [2, 2, 5])
    assert one_constant.df == pytest.approx(2)
    assert one_constant.statistic == pytest.approx(-2 / math.sqrt(3 / 3))
    assert one_constant.effect_size == pytest.approx(-2 / math.sqrt(2 * 3 / 5) * (1 - 3 / 19))


def test_welch_interval_has_its_coverage():
    rng = np.random.default_rng(3)
    results = [welch(rng.normal(1, 1, 10), rng.normal(0, 4, 25), 0.8) for _ in range(400)]
    assert 0.76 < np.mean([r.ci_low < 1 < r.ci_high for r in results]) < 0.84


# ---- invalid arguments ---------------------------------------------------------------------------


def test_invalid_groups_are_rejected():
    comparisons = (
        welch,
        lambda a, b: games_howell({"a": a, "b": b}),
        mann_whitney,
        lambda a, b: probability_of_improvement(a, b, np.random.default_rng(0), 9),
        lambda a, b: permutation_test(a, b, np.random.default_rng(0), 9),
    )
    cases = (
        ([1.0], "at least 2"),
        ([], "at least 2"),
        ([[1.0, 2.0]], "one dimension"),
        ([1.0, np.nan], "1 values"),
        ([1.0, np.inf, np.nan], "2 values"),
    )
    for compare in comparisons:
        for invalid, message in cases:
            with pytest.raises(ValueError, match=message):
                compare(invalid, B)
            with pytest.raises(ValueError, match=message):
                compare(A, invalid)


def test_confidence_must_be_a_fraction():
    for confidence in (0, 1, 95):
        with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
            welch(A, B, confidence)
        with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
            games_howell({"a": A, "b": B}, confidence)
        with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
            probability_of_improvement(A, B, np.random.default_rng(0), 9, confidence)


# ---- Games-Howell --------------------------------------------------------------------------------


def test_games_howell_agrees_with_its_formula():
    confidence = 0.9
    groups = {"a": normal(1, 30, 1), "b": normal(2, 12, 0, 4), "c": normal(3, 20, 0.5, 0.2)}
    comparisons = games_howell(groups, confidence)
    assert list(comparisons) == [("a", "b"), ("a", "c"), ("b", "c")]
    for (a, b), pair in comparisons.items():
        single = welch(groups[a], groups[b])
        error = abs(single.difference / single.statistic)
        half = stats.studentized_range.ppf(confidence, 3, single.df) * error / math.sqrt(2)
        p = stats.studentized_range.sf(math.sqrt(2) * abs(single.statistic), 3, single.df)
        assert pair.difference == pytest.approx(single.difference)
        assert pair.p == pytest.approx(p, rel=1e-6)
        ends = (pair.difference - half, pair.difference + half)
        assert (pair.ci_low, pair.ci_high) == pytest.approx(ends, rel=1e-6)


def test_games_howell_of_two_groups_is_welch():
    (pair,), single = games_howell({"a": A, "b": B}).values(), welch(A, B)
    expected = (single.difference, single.p, single.ci_low, single.ci_high)
    assert pair == pytest.approx(expected, rel=1e-6)


def test_games_howell_with_constant_groups():
    pairs = games_howell({"a": [1, 1, 1], "b": [0.1] * 3, "c": [0.1] * 7, "d": [1, 2, 4]})
    assert pairs["a", "b"] == pairs["a", "c"] == (0.9, 0, 0.9, 0.9)
    assert pairs["b", "c"] == (0, 1, 0, 0)
    assert pairs["a", "d"].difference == pytest.approx(-4 / 3)
    assert 0 < pairs["a", "d"].p < 1
    assert np.isfinite(list(pairs.values())).all()


def test_games_howell_needs_two_groups():
    with pytest.raises(ValueError, match="at least two groups"):
        games_howell({"a": A})


# ---- ranks ---------------------------------------------------------------------------------------


def test_mann_whitney_by_hand():
    """U counts 12 pairs: 11 wins and a tie. 1 of 20 orders of six values is as extreme per side."""
    assert mann_whitney(A, B).statistic == 11.5
    assert mann_whitney([4, 5, 6], [1, 2, 3]) == (9, pytest.approx(2 / 20))
    assert mann_whitney([1, 2, 3], [4, 5, 6]) == (0, pytest.approx(2 / 20))
    assert mann_whitney([1, 1, 1], [1, 1]) == (3, 1)


def test_mann_whitney_uses_the_normal_approximation_for_ties():
    a, b = normal(1, 30, 0.5).round(1), normal(2, 25).round(1)
    u = sum((x > b).sum() + (x == b).sum() / 2 for x in a)
    counts = np.unique(np.append(a, b), return_counts=True)[1]
    variance = 30 * 25 / 12 * (56 - (counts**3 - counts).sum() / (55 * 54))
    p = 2 * stats.norm.sf((abs(u - 375) - 0.5) / math.sqrt(variance))
    assert mann_whitney(a, b) == (u, pytest.approx(p))


def test_probability_of_improvement_is_u_over_pairs():
    rng = np.random.default_rng(0)
    assert probability_of_improvement(A, B, rng, 99).probability == pytest.approx(11.5 / 12)
    assert probability_of_improvement(B, A, rng, 99).probability == pytest.approx(0.5 / 12)
    a, b = normal(1, 30, 0.5).round(1), normal(2, 25).round(1)
    expected = mann_whitney(a, b).statistic / 750
    assert probability_of_improvement(a, b, rng, 99).probability == pytest.approx(expected)


def test_probability_of_improvement_of_disjoint_or_equal_groups():
    rng = np.random.default_rng(0)
    assert probability_of_improvement(normal(1, 29) + 100, normal(2, 30), rng) == (1, 1, 1)
    assert probability_of_improvement(normal(1, 29), normal(2, 30) + 100, rng) == (0, 0, 0)
    assert probability_of_improvement([5, 5, 5], [5, 5], rng) == (0.5, 0.5, 0.5)


def test_probability_of_improvement_agrees_with_a_naive_bootstrap():
    a, b = normal(1, 20, 0.5).round(1), normal(2, 10).round(1)
    for confidence in (0.95, 0.5):
        rng = np.random.default_rng(5)
        _, low, high = probability_of_improvement(a, b, rng, 4000, confidence)
        naive = []
        for _ in range(4000):
            x, y = rng.choice(a, 20), rng.choice(b, 10)
            naive.append((x[:, None] > y).mean() + (x[:, None] == y).mean() / 2)
        expected = np.quantile(naive, [0.5 - confidence / 2, 0.5 + confidence / 2])
        assert (low, high) == pytest.approx(expected, abs=0.015), confidence


# ---- permutation ---------------------------------------------------------------------------------


def test_permutation_test_of_few_runs_counts_all_partitions():
    c, d = np.array([1.0, 7.0, 9.0]), np.array([2.0, 6.0, 3.0, 4.0])
    for a, b in ((A, B), (B, A), (c, d)):
        pooled, observed = np.append(a, b), a.mean() - b.mean()
        differences = np.array(
            [
                pooled[list(i)].mean() - np.delete(pooled, i).mean()
                for i in combinations(range(7), len(a))
            ]
        )
        above, below = differences >= observed - 1e-9, differences <= observed + 1e-9
        expected = min(1, 2 * min(above.mean(), below.mean()))
        assert permutation_test(a, b, np.random.default_rng(0)) == pytest.approx(expected)


def test_permutation_test_of_many_runs_is_close_to_the_t_test():
    a, b = normal(1, 30, 0.5), normal(2, 30)
    p = stats.ttest_ind(a, b).pvalue
    assert 0.005 < p < 0.2
    assert permutation_test(a, b, np.random.default_rng(0)) == pytest.approx(p, abs=0.01)


def test_permutation_test_at_its_limits():
    a, b = normal(1, 20), normal(2, 20)
    for x, y in ((a + 50, b), (a, b + 50)):
        p = permutation_test(x, y, np.random.default_rng(0), 499)
        assert p == pytest.approx(2 / 500)
    assert permutation_test([0.1] * 9, [0.1] * 7, np.random.default_rng(0), 99) == 1


def test_equal_generators_give_equal_results():
    a, b = normal(1, 20), normal(2, 20)
    for test in (permutation_test, probability_of_improvement):
        results = [test(a, b, np.random.default_rng(7), 99) for _ in range(2)]
        assert results[0] == results[1], test
