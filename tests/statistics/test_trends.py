"""Cochran-Armitage and Cochran-Mantel-Haenszel tests."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2, chi2_contingency, kstest
from statsmodels.stats.contingency_tables import StratifiedTable

from sensory_commutativity.statistics.trends import cochran_armitage, mantel_haenszel

# ---- Cochran-Armitage ----------------------------------------------------------------------------


def test_trend_of_a_published_example():
    """Alcohol and malformations (Agresti, Categorical Data Analysis, section 5.3.5).

    There z**2 = 6.57, p = 0.010, and a linear fit has slope 0.0017.
    """
    trend = cochran_armitage([48, 38, 5, 1, 1], [17114, 14502, 793, 127, 38], [0, 0.5, 1.5, 4, 7])
    assert trend.z**2 == pytest.approx(6.5701, abs=1e-4)
    assert trend.p == pytest.approx(0.0104, abs=5e-5)
    assert trend.z > 0
    assert trend.slope == pytest.approx(0.0017, abs=5e-5)


def test_trend_by_hand():
    """8, 5 and 2 of 10 at scores 0, 1, 2: slope -0.3; z = -6 / sqrt(1/4 * 20)."""
    trend = cochran_armitage([8, 5, 2], [10, 10, 10], [0, 1, 2])
    assert trend.slope == pytest.approx(-0.3)
    assert trend.z == pytest.approx(-6 / math.sqrt(5))
    assert trend.p == pytest.approx(math.erfc(6 / math.sqrt(5) / math.sqrt(2)))


@given(st.integers(1, 39), st.integers(1, 59), st.floats(-5, 5), st.floats(0.1, 10))
def test_trend_of_two_groups_is_the_chi_square_test(a, b, first, step):
    trend = cochran_armitage([a, b], [40, 60], [first, first + step])
    expected = chi2_contingency([[a, 40 - a], [b, 60 - b]], correction=False)
    assert trend.z**2 == pytest.approx(expected.statistic, abs=1e-8)
    assert trend.p == pytest.approx(expected.pvalue, abs=1e-8)
    assert trend.slope == pytest.approx((b / 60 - a / 40) / step)


def test_trend_slope_is_weighted_least_squares():
    rng = np.random.default_rng(1)
    n, scores = rng.integers(10, 100, 6), np.array([0.0, 4, 8, 12, 13, 20])
    successes = rng.binomial(n, 0.3)
    outcomes = [np.arange(m) < k for k, m in zip(successes, n, strict=True)]
    slope = np.polyfit(np.repeat(scores, n), np.concatenate(outcomes).astype(float), 1)[0]
    assert cochran_armitage(successes, n, scores).slope == pytest.approx(slope)


def test_trend_is_invariant_to_the_scale_of_the_scores():
    scales = ((1, 0), (10, 0), (1, -100))
    z = [
        cochran_armitage([3, 5, 9], [20] * 3, np.array([0, 4, 8]) * scale + shift).z
        for scale, shift in scales
    ]
    assert z == pytest.approx([z[0]] * 3)
    assert cochran_armitage([3, 5, 9], [20] * 3, [8, 4, 0]).z == pytest.approx(-z[0])


def test_trend_of_constant_outcomes_or_scores():
    for successes, scores in (([10, 10], [0, 1]), ([0, 0], [0, 1]), ([3, 7], [2, 2])):
        assert cochran_armitage(successes, [10, 10], scores) == (0.0, 0.0, 1.0)


def test_trend_has_level_and_power():
    rng, n, scores = np.random.default_rng(31), [300] * 4, [0, 4, 8, 12]
    p = np.array([cochran_armitage(rng.binomial(300, 0.4, 4), n, scores).p for _ in range(600)])
    assert kstest(p, "uniform").pvalue > 0.01
    assert 0.03 < np.mean(p <= 0.05) < 0.075
    rng, rates = np.random.default_rng(32), [0.9, 0.85, 0.8, 0.75]
    p = np.array([cochran_armitage(rng.binomial(300, rates), n, scores).p for _ in range(50)])
    assert np.mean(p < 0.05) > 0.95


# ---- Cochran-Mantel-Haenszel ---------------------------------------------------------------------

A, N_A = np.array([8, 12, 20]), np.array([20, 30, 40])
B, N_B = np.array([4, 10, 12]), np.array([25, 30, 35])


def expected_comparison(a, n_a, b, n_b) -> tuple[float, float]:
    """Pooled odds ratio, and p of the test without continuity correction."""
    a, n_a, b, n_b = (np.asarray(x, float) for x in (a, n_a, b, n_b))
    n, successes = n_a + n_b, a + b
    odds_ratio = (a * (n_b - b) / n).sum() / ((n_a - a) * b / n).sum()
    expected = n_a * successes / n
    variance = n_a * n_b * successes * (n - successes) / (n**2 * (n - 1))
    return odds_ratio, float(chi2.sf((a - expected).sum() ** 2 / variance.sum(), 1))


def test_strata_agree_with_the_formula_and_statsmodels():
    result = mantel_haenszel(A, N_A, B, N_B)
    assert result == pytest.approx(expected_comparison(A, N_A, B, N_B))
    table = StratifiedTable(
        [np.array([[a, n - a], [b, m - b]]) for a, n, b, m in zip(A, N_A, B, N_B, strict=True)]
    )
    assert result.odds_ratio == pytest.approx(table.oddsratio_pooled)
    assert result.p == pytest.approx(table.test_null_odds(correction=False).pvalue)


def test_strata_of_a_published_example():
    """Trial of a cream in eight centres (Agresti, Categorical Data Analysis, table 6.9).

    There the test has p = 0.012 and the odds ratio is 2.13.
    """
    result = mantel_haenszel(
        [11, 16, 14, 2, 6, 1, 1, 4],
        [36, 20, 19, 16, 17, 11, 5, 6],
        [10, 22, 7, 1, 0, 0, 1, 6],
        [37, 32, 19, 17, 12, 10, 9, 7],
    )
    assert result.odds_ratio == pytest.approx(2.13, abs=0.01)
    assert result.p == pytest.approx(0.012, abs=0.0005)


def test_one_stratum_is_nearly_the_chi_square_test():
    result = mantel_haenszel([30], [50], [20], [60])
    statistic = chi2_contingency([[30, 20], [20, 40]], correction=False).statistic
    assert result.p == pytest.approx(chi2.sf(statistic * 109 / 110, 1))  # CMH divides by n - 1
    assert result.odds_ratio == pytest.approx(30 * 40 / (20 * 20))


def test_groups_can_be_swapped():
    ab, ba = mantel_haenszel(A, N_A, B, N_B), mantel_haenszel(B, N_B, A, N_A)
    assert ba.odds_ratio == pytest.approx(1 / ab.odds_ratio)
    assert ba.p == pytest.approx(ab.p)


def test_strata_with_a_single_outcome_are_dropped():
    result = mantel_haenszel([*A, 50, 0], [*N_A, 50, 9], [*B, 50, 0], [*N_B, 50, 9])
    assert result == pytest.approx(mantel_haenszel(A, N_A, B, N_B))
    for k in (0, 10):
        assert mantel_haenszel([k, k], [10, 10], [k, k], [10, 10]) == (1.0, 1.0)


def test_a_group_without_failures():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # statsmodels divides by zero
        result = mantel_haenszel([10, 8], [10, 8], [5, 4], [10, 8])
    assert result.odds_ratio == math.inf
    with np.errstate(divide="ignore"):
        assert result.p == pytest.approx(expected_comparison([10, 8], [10, 8], [5, 4], [10, 8])[1])


def test_strata_p_is_uniform_without_a_difference():
    rng, p = np.random.default_rng(7), []
    rates = np.array([0.9, 0.6, 0.4])  # strata differ, groups do not
    for _ in range(300):
        a, b = rng.binomial(150, rates), rng.binomial(100, rates)
        p.append(mantel_haenszel(a, [150] * 3, b, [100] * 3).p)
    assert kstest(p, "uniform").pvalue > 0.01
    assert 0.02 < np.mean(np.array(p) <= 0.05) < 0.09
