"""Power of the t-test, and the runs that a comparison needs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from statsmodels.stats.power import TTestIndPower

from sensory_commutativity.statistics.power import (
    MAX_RUNS,
    detectable_effect,
    power_of_t_test,
    runs_needed,
)

pytestmark = pytest.mark.filterwarnings("error")

# Planning table. alpha -> power of 30 runs at d = 0.5, 0.8, 1.0, 1.2; effect detected with 80 %;
# runs needed for d = 0.5, 0.8, 1.0.
PLANNING = {
    0.05: ([0.48, 0.86, 0.97, 0.995], 0.74, [64, 26, 17]),
    0.05 / 3: ([0.31, 0.74, 0.92, 0.98], 0.86, [86, 35, 23]),
    0.01: ([0.24, 0.67, 0.88, 0.97], 0.91, [96, 39, 26]),
    0.01 / 3: ([0.14, 0.52, 0.79, 0.94], 1.01, [117, 47, 31]),
}


def test_planning_table():
    for alpha, (powers, effect, runs) in PLANNING.items():
        power = [power_of_t_test(d, 30, alpha) for d in (0.5, 0.8, 1.0, 1.2)]
        assert power == pytest.approx(powers, abs=0.0056), alpha
        assert detectable_effect(30, alpha) == pytest.approx(effect, abs=0.005), alpha
        assert [runs_needed(d, alpha) for d in (0.5, 0.8, 1.0)] == runs, alpha


def test_power_agrees_with_statsmodels():
    """TTestIndPower is NaN for many large effects; ours must be finite there."""
    effects = np.linspace(0, 3, 31)
    for n in (2, 5, 30, 500):
        for alpha in (0.05, 0.01, 0.001):
            with np.errstate(all="ignore"):
                expected = np.array([TTestIndPower().power(d, n, alpha) for d in effects])
            defined = np.isfinite(expected)
            assert defined.sum() > 8
            power = np.array([power_of_t_test(d, n, alpha) for d in effects])
            assert power[defined] == pytest.approx(expected[defined], abs=1e-9), (n, alpha)
            assert (np.diff(power) >= -1e-12).all() and np.isfinite(power).all(), (n, alpha)


def test_power_agrees_with_a_simulation():
    rng = np.random.default_rng(0)
    p = stats.ttest_ind(rng.normal(0.9, 1, (4000, 15)), rng.normal(0, 1, (4000, 15)), axis=1).pvalue
    assert power_of_t_test(0.9, 15, 0.02) == pytest.approx((p < 0.02).mean(), abs=0.025)


def test_power_of_no_effect_and_of_a_huge_one():
    assert power_of_t_test(0, 30, 0.03) == 0.03
    assert power_of_t_test(1e-200, 30, 0.03) == 0.03
    assert power_of_t_test(2e-9, 30, 0.03) == pytest.approx(0.03)
    assert power_of_t_test(2.5, 30, 0.05) == pytest.approx(1)
    assert power_of_t_test(math.inf, 2, 0.001) == power_of_t_test(-math.inf, 2, 0.001)
    assert power_of_t_test(math.inf, 2, 0.001) == pytest.approx(1)
    assert power_of_t_test(-0.8, 30, 0.05) == power_of_t_test(0.8, 30, 0.05)


def test_detectable_effect_has_the_power_and_needs_the_runs():
    for n in (2, 3, 30, 2000):
        for alpha in (0.05, 0.0033, 0.0001):
            for power in (0.5, 0.8, 0.95):
                d = detectable_effect(n, alpha, power)
                assert power_of_t_test(d, n, alpha) == pytest.approx(power, abs=1e-6)
                assert runs_needed(d, alpha, power) == n


def test_runs_needed_is_the_smallest_number():
    for d in (0.02, 0.3, -0.77, 1.5, 4.0):
        n = runs_needed(d, 0.01, 0.9)
        assert n == int(n) > 2
        assert power_of_t_test(d, n - 1, 0.01) < 0.9 <= power_of_t_test(d, n, 0.01), d


def test_runs_needed_has_limits():
    assert runs_needed(0, 0.05) == math.inf
    assert runs_needed(0.001, 0.05) == math.inf  # 16 million
    assert 500_000 < runs_needed(0.005, 0.05) < MAX_RUNS
    assert runs_needed(1e5, 0.05) == runs_needed(math.inf, 0.05) == 2


def test_invalid_arguments_are_rejected():
    cases = (
        (lambda: power_of_t_test(0.5, 1, 0.05), "at least 2 runs"),
        (lambda: power_of_t_test(0.5, math.nan, 0.05), "at least 2 runs"),
        (lambda: power_of_t_test(math.nan, 30, 0.05), "effect size"),
        (lambda: power_of_t_test(0.5, 30, 5), "alpha must lie between 0 and 1"),
        (lambda: detectable_effect(1, 0.05), "at least 2 runs"),
        (lambda: detectable_effect(30, 0.05, 80), "power must lie between 0 and 1"),
        (lambda: detectable_effect(30, 0.05, 0.05), "ask for more than 0.05"),
        (lambda: runs_needed(math.nan, 0.05), "effect size"),
        (lambda: runs_needed(0.5, 0.05, 0.01), "ask for more than 0.01"),
    )
    for call, message in cases:
        with pytest.raises(ValueError, match=message):
            call()
