"""statistics/groups.py and checks.py: two groups of runs compared."""

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
    permutation,
    probability_of_improvement,
    welch,
)

pytestmark = pytest.mark.filterwarnings("error")

A, B = np.array([3.0, 4.0, 5.0, 8.0]), np.array([1.0, 2.0, 3.0])


def runs(seed: int, n: int, mean: float = 0.0, sd: float = 1.0) -> np.ndarray:
    return np.random.default_rng(seed).normal(mean, sd, n)


# ---- Welch -----------------------------------------------------------------------------------------------------------------


def test_welch_by_hand():
    """Means 5 and 2, variances 14/3 and 1: squared errors 7/6 and 1/3."""
    found = welch(A, B)
    error, df = (
        math.sqrt(7 / 6 + 1 / 3),
        (7 / 6 + 1 / 3) ** 2 / ((7 / 6) ** 2 / 3 + (1 / 3) ** 2 / 2),
    )
    half = stats.t.ppf(0.975, df) * error
    assert found.difference == 3
    assert (found.statistic, found.df) == pytest.approx((3 / error, df))
    assert found.p == pytest.approx(2 * stats.t.sf(3 / error, df))
    assert (found.ci_low, found.ci_high) == pytest.approx((3 - half, 3 + half))
    assert found.effect_size == pytest.approx(
        3 / math.sqrt((3 * 14 / 3 + 2 * 1) / 5) * (1 - 3 / 19)
    )


@pytest.mark.parametrize(
    ("n", "m", "sd", "confidence"), [(30, 30, 1, 0.95), (12, 40, 5, 0.99), (2, 3, 0.1, 0.5)]
)
def test_welch_against_statsmodels(n, m, sd, confidence):
    a, b = runs(1, n, 2, sd), runs(2, m)
    found, other = welch(a, b, confidence), CompareMeans(DescrStatsW(a), DescrStatsW(b))
    assert (found.statistic, found.p, found.df) == pytest.approx(other.ttest_ind(usevar="unequal"))
    assert (found.ci_low, found.ci_high) == pytest.approx(
        other.tconfint_diff(alpha=1 - confidence, usevar="unequal")
    )
    assert found.effect_size == pytest.approx(
        effectsize_smd(a.mean(), a.std(ddof=1), n, b.mean(), b.std(ddof=1), m)[0]
    )


@given(st.integers(0, 1000), st.integers(2, 20), st.integers(2, 20))
@settings(max_examples=25, deadline=None)
def test_welch_mirrors(seed, n, m):
    a, b = runs(seed, n), runs(seed + 1, m, 1)
    found, mirrored = welch(a, b), welch(b, a)
    assert (mirrored.p, mirrored.df) == pytest.approx((found.p, found.df))
    assert (mirrored.statistic, mirrored.difference, mirrored.effect_size) == pytest.approx(
        (-found.statistic, -found.difference, -found.effect_size)
    )
    assert (mirrored.ci_low, mirrored.ci_high) == pytest.approx((-found.ci_high, -found.ci_low))
    assert found.ci_low < found.difference < found.ci_high


def test_welch_of_constant_groups():
    assert welch([0.1] * 3, [0.1] * 7) == (0, 8, 1, 0, 0, 0, 0)  # the mean of seven 0.1 is not 0.1
    assert welch([2, 2], [1, 1, 1]) == (math.inf, 3, 0, 1, 1, 1, math.inf)
    assert welch([1, 1, 1], [3, 3]) == (-math.inf, 3, 0, -2, -2, -2, -math.inf)


def test_welch_of_one_constant_group():
    found = welch([1, 1, 1, 1], [2, 2, 5])
    assert found.df == pytest.approx(2)
    assert found.statistic == pytest.approx(-2 / math.sqrt(3 / 3))
    assert found.effect_size == pytest.approx(-2 / math.sqrt(2 * 3 / 5) * (1 - 3 / 19))


def test_welch_covers_as_often_as_it_says():
    rng = np.random.default_rng(3)
    found = [welch(rng.normal(1, 1, 10), rng.normal(0, 4, 25), 0.8) for _ in range(400)]
    assert 0.76 < np.mean([w.ci_low < 1 < w.ci_high for w in found]) < 0.84


# ---- what is refused -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        ([1.0], "at least 2"),
        ([], "at least 2"),
        ([[1.0, 2.0]], "one dimension"),
        ([1.0, np.nan], "1 values"),
        ([1.0, np.inf, np.nan], "2 values"),
    ],
)
@pytest.mark.parametrize(
    "compare",
    [
        welch,
        lambda a, b: games_howell({"a": a, "b": b}),
        mann_whitney,
        lambda a, b: probability_of_improvement(a, b, np.random.default_rng(0), 9),
        lambda a, b: permutation(a, b, np.random.default_rng(0), 9),
    ],
)
def test_groups_that_are_refused(compare, bad, says):
    with pytest.raises(ValueError, match=says):
        compare(bad, B)
    with pytest.raises(ValueError, match=says):
        compare(A, bad)


@pytest.mark.parametrize("confidence", [0, 1, 95])
def test_confidence_is_a_fraction(confidence):
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        welch(A, B, confidence)
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        games_howell({"a": A, "b": B}, confidence)
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        probability_of_improvement(A, B, np.random.default_rng(0), 9, confidence)


# ---- Games-Howell ----------------------------------------------------------------------------------------------------------


def test_games_howell_against_its_formula():
    confidence = 0.9
    groups = {
        "full": runs(1, 30, 1),
        "truncated": runs(2, 12, 0, 4),
        "adapted": runs(3, 20, 0.5, 0.2),
    }
    found = games_howell(groups, confidence)
    assert list(found) == [("full", "truncated"), ("full", "adapted"), ("truncated", "adapted")]
    for (a, b), pair in found.items():
        alone = welch(groups[a], groups[b])
        error = abs(alone.difference / alone.statistic)
        half = stats.studentized_range.ppf(confidence, 3, alone.df) * error / math.sqrt(2)
        assert pair.difference == pytest.approx(alone.difference)
        assert pair.p == pytest.approx(
            stats.studentized_range.sf(math.sqrt(2) * abs(alone.statistic), 3, alone.df), rel=1e-6
        )
        assert (pair.ci_low, pair.ci_high) == pytest.approx(
            (pair.difference - half, pair.difference + half), rel=1e-6
        )


def test_games_howell_of_two_groups_is_welch():
    (pair,), alone = games_howell({"a": A, "b": B}).values(), welch(A, B)
    assert pair == pytest.approx((alone.difference, alone.p, alone.ci_low, alone.ci_high), rel=1e-6)


def test_games_howell_with_constant_groups():
    found = games_howell({"a": [1, 1, 1], "b": [0.1] * 3, "c": [0.1] * 7, "d": [1, 2, 4]})
    assert found["a", "b"] == found["a", "c"] == (0.9, 0, 0.9, 0.9)
    assert found["b", "c"] == (0, 1, 0, 0)
    assert found["a", "d"].difference == pytest.approx(-4 / 3)
    assert 0 < found["a", "d"].p < 1
    assert np.isfinite(list(found.values())).all()


def test_games_howell_needs_two_groups():
    with pytest.raises(ValueError, match="at least two groups"):
        games_howell({"full": A})


# ---- ranks -----------------------------------------------------------------------------------------------------------------


def test_mann_whitney_by_hand():
    """U: 12 pairs, 11 wins and a tie. Without overlap 1 of the 20 ways to place three of six, on either side."""
    assert mann_whitney(A, B).statistic == 11.5
    assert mann_whitney([4, 5, 6], [1, 2, 3]) == (9, pytest.approx(2 / 20))
    assert mann_whitney([1, 2, 3], [4, 5, 6]) == (0, pytest.approx(2 / 20))
    assert mann_whitney([1, 1, 1], [1, 1]) == (3, 1)


def test_mann_whitney_against_the_normal_approximation():
    a, b = runs(1, 30, 0.5).round(1), runs(2, 25).round(1)  # with ties
    u = sum((x > b).sum() + (x == b).sum() / 2 for x in a)
    counts = np.unique(np.append(a, b), return_counts=True)[1]
    variance = 30 * 25 / 12 * (56 - (counts**3 - counts).sum() / (55 * 54))
    assert mann_whitney(a, b) == (
        u,
        pytest.approx(2 * stats.norm.sf((abs(u - 375) - 0.5) / math.sqrt(variance))),
    )


def test_probability_of_improvement_is_u_over_pairs():
    rng = np.random.default_rng(0)
    assert probability_of_improvement(A, B, rng, 99).probability == pytest.approx(11.5 / 12)
    assert probability_of_improvement(B, A, rng, 99).probability == pytest.approx(0.5 / 12)
    a, b = runs(1, 30, 0.5).round(1), runs(2, 25).round(1)
    assert probability_of_improvement(a, b, rng, 99).probability == pytest.approx(
        mann_whitney(a, b).statistic / 750
    )


def test_probability_of_improvement_where_groups_do_not_overlap_or_are_equal():
    rng = np.random.default_rng(0)
    assert probability_of_improvement(runs(1, 29) + 100, runs(2, 30), rng) == (1, 1, 1)
    assert probability_of_improvement(runs(1, 29), runs(2, 30) + 100, rng) == (0, 0, 0)
    assert probability_of_improvement([5, 5, 5], [5, 5], rng) == (0.5, 0.5, 0.5)


@pytest.mark.parametrize("confidence", [0.95, 0.5])
def test_probability_of_improvement_against_a_plain_bootstrap(confidence):
    a, b, rng = runs(1, 20, 0.5).round(1), runs(2, 10).round(1), np.random.default_rng(5)
    _, low, high = probability_of_improvement(a, b, rng, 4000, confidence)
    plain = []
    for _ in range(4000):
        x, y = rng.choice(a, 20), rng.choice(b, 10)
        plain.append((x[:, None] > y).mean() + (x[:, None] == y).mean() / 2)
    assert (low, high) == pytest.approx(
        np.quantile(plain, [0.5 - confidence / 2, 0.5 + confidence / 2]), abs=0.015
    )


# ---- permutation -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("a", "b"), [(A, B), (B, A), (np.array([1.0, 7.0, 9.0]), np.array([2.0, 6.0, 3.0, 4.0]))]
)
def test_permutation_of_few_runs_counts_all_arrangements(a, b):
    pooled, observed = np.append(a, b), a.mean() - b.mean()
    each = [
        pooled[list(i)].mean() - np.delete(pooled, i).mean() for i in combinations(range(7), len(a))
    ]
    tail = min(
        np.mean(np.array(each) >= observed - 1e-9), np.mean(np.array(each) <= observed + 1e-9)
    )
    assert permutation(a, b, np.random.default_rng(0)) == pytest.approx(min(1, 2 * tail))


def test_permutation_of_many_runs_is_near_the_t_test():
    a, b = runs(1, 30, 0.5), runs(2, 30)
    p = stats.ttest_ind(a, b).pvalue
    assert 0.005 < p < 0.2
    assert permutation(a, b, np.random.default_rng(0)) == pytest.approx(p, abs=0.01)


def test_permutation_at_its_limits():
    assert permutation(
        runs(1, 20) + 50, runs(2, 20), np.random.default_rng(0), 499
    ) == pytest.approx(2 / 500)
    assert permutation(
        runs(1, 20), runs(2, 20) + 50, np.random.default_rng(0), 499
    ) == pytest.approx(2 / 500)
    assert permutation([0.1] * 9, [0.1] * 7, np.random.default_rng(0), 99) == 1


@pytest.mark.parametrize(
    "test",
    [
        lambda rng: permutation(runs(1, 20), runs(2, 20), rng, 99),
        lambda rng: probability_of_improvement(A, B, rng, 99),
    ],
)
def test_equal_generators_give_equal_results(test):
    assert test(np.random.default_rng(7)) == test(np.random.default_rng(7))
