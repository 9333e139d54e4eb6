"""McNemar's test, its interval, t-tests of paired differences, Holm's correction."""

from __future__ import annotations

import gc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest
from statsmodels.stats import contingency_tables
from statsmodels.stats.weightstats import DescrStatsW

from sensory_commutativity.statistics.paired import (
    equivalence_test,
    holm,
    mcnemar,
    paired_difference_interval,
    paired_means,
    score_statistic,
)


@pytest.fixture(scope="module", autouse=True)
def no_garbage_collection():
    """statsmodels collects garbage in every call of multipletests: 0.1 s in a large process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gc, "collect", lambda *_: 0)
        yield


def pairs(both: int, only_a: int, only_b: int, neither: int) -> tuple[np.ndarray, ...]:
    """Two boolean arrays with these counts."""
    kinds = [(True, True), (True, False), (False, True), (False, False)]
    return tuple(np.repeat(np.array(kinds), [both, only_a, only_b, neither], axis=0).T)


# ---- McNemar -------------------------------------------------------------------------------------


def test_mcnemar_by_hand():
    result = mcnemar(*pairs(both=3, only_a=5, only_b=1, neither=1))
    assert (result.only_a, result.only_b) == (5, 1)
    assert result.difference == pytest.approx(8 / 10 - 4 / 10)
    assert result.p == pytest.approx(2 * (1 + 6) / 2**6)  # 0 or 1 of 6 fair coins, on either side
    cases = ((0, 0, 1.0), (1, 0, 1.0), (4, 4, 1.0), (6, 0, 2 / 64), (0, 10, 2 / 1024))
    for only_a, only_b, p in cases:
        assert mcnemar(*pairs(2, only_a, only_b, 2)).p == pytest.approx(p), (only_a, only_b)


@given(st.integers(0, 40), st.integers(0, 40), st.integers(0, 40), st.integers(0, 40))
def test_mcnemar_agrees_with_scipy_and_statsmodels(both, only_a, only_b, neither):
    a, b = pairs(both, only_a, only_b, neither)
    if not len(a):
        return
    result = mcnemar(a, b)
    if only_a + only_b:
        assert result.p == pytest.approx(binomtest(only_a, only_a + only_b, 0.5).pvalue)
        table = [[both, only_a], [only_b, neither]]
        assert result.p == pytest.approx(contingency_tables.mcnemar(table, exact=True).pvalue)
    assert result.difference == pytest.approx(a.mean() - b.mean())
    swapped = mcnemar(b, a)
    assert (swapped.only_a, swapped.only_b, swapped.p) == (only_b, only_a, result.p)
    assert swapped.difference == -result.difference


def test_mcnemar_uses_the_pairing_and_accepts_zeros_and_ones():
    a = np.array([True, False] * 10)
    assert mcnemar(a, a).p == 1.0
    assert mcnemar(a, ~a)[:2] == (10, 10)
    x, y = np.array([1, 1, 0]), np.array([0, 1, 0])
    assert mcnemar(x, y) == mcnemar(x.astype(bool), y.astype(bool))


def test_mcnemar_rejects_unpaired_arrays():
    for a, b in (([True], [True, False]), ([], []), ([[True]], [True])):
        with pytest.raises(ValueError, match="paired"):
            mcnemar(np.array(a, bool), np.array(b, bool))


def test_mcnemar_keeps_its_level():
    """Under the null hypothesis an exact test rejects at most as often as its level."""
    rng = np.random.default_rng(20)
    p = np.array([mcnemar(rng.random(60) < 0.4, rng.random(60) < 0.4).p for _ in range(400)])
    for level in (0.05, 0.2, 0.5):
        rejected = (p <= level).mean()
        assert level / 3 < rejected < level + 2.5 * math.sqrt(level * (1 - level) / 400)


# ---- the interval of the difference of proportions -----------------------------------------------


def test_difference_interval_without_discordant_pairs_by_hand():
    z = 1.959963984540054
    for n in (1, 10, 400):
        ends = paired_difference_interval(0, 0, n)
        assert ends == pytest.approx((-(z**2) / (n + z**2), z**2 / (n + z**2)))


def test_difference_interval_holds_what_the_score_test_does_not_reject():
    for counts in ((5, 1, 10), (2, 0, 400), (30, 12, 90)):
        for end in paired_difference_interval(*counts):
            assert abs(score_statistic(*counts, end)) == pytest.approx(1.959963984540054)


@given(st.integers(0, 50), st.integers(0, 50), st.integers(0, 50))
def test_difference_interval_holds_the_difference_and_is_antisymmetric(only_a, only_b, rest):
    n = only_a + only_b + rest
    if not n:
        return
    low, high = paired_difference_interval(only_a, only_b, n)
    assert -1 <= low < high <= 1
    assert low <= (only_a - only_b) / n <= high
    assert paired_difference_interval(only_b, only_a, n) == pytest.approx((-high, -low))
    wider = paired_difference_interval(only_a, only_b, n, 0.99)
    assert wider[0] <= low + 1e-12 and wider[1] >= high - 1e-12


@pytest.mark.parametrize(
    "a, b, n, least, most",
    [(0.6, 0.4, 80, 0.94, 0.965), (0.995, 1.0, 400, 0.93, 0.99), (0.99, 1.0, 400, 0.925, 0.96),
     (0.98, 0.98, 400, 0.94, 0.965), (0.9, 0.95, 400, 0.935, 0.96)],
)  # fmt: skip
def test_difference_interval_has_its_coverage_also_near_one(a, b, n, least, most):
    both, rng = a * b, np.random.default_rng(8)
    cells = rng.multinomial(n, [both, a - both, b - both, max(0, 1 - a - b + both)], 1500)
    intervals = {}
    for counts in set(map(tuple, cells[:, 1:3].tolist())):
        intervals[counts] = paired_difference_interval(*counts, n)
    inside = [low <= a - b <= high for low, high in (intervals[tuple(c)] for c in
                                                     cells[:, 1:3].tolist())]  # fmt: skip
    assert least < np.mean(inside) < most


def test_equivalence_is_shown_by_data_within_the_margin_alone():
    assert equivalence_test(100, 102, 10_000, 0.02) < 1e-6
    assert equivalence_test(300, 100, 10_000, 0.02) == pytest.approx(0.5, abs=0.01)
    assert equivalence_test(500, 100, 10_000, 0.02) > 0.99
    assert equivalence_test(0, 0, 10, 0.02) > 0.1  # ten pairs show nothing
    assert equivalence_test(5, 9, 400, 0.05) == equivalence_test(9, 5, 400, 0.05)
    with pytest.raises(ValueError, match="margin"):
        equivalence_test(1, 1, 10, 0.0)


# ---- paired means --------------------------------------------------------------------------------


def test_paired_means_is_the_one_sample_t_test():
    difference = np.random.default_rng(0).normal(0.3, 1, 25)
    low, high, p = paired_means(difference)
    expected = DescrStatsW(difference)
    assert (low, high) == pytest.approx(expected.tconfint_mean())
    assert p == pytest.approx(expected.ttest_mean(0)[1])
    assert paired_means(difference, 0.5)[:2] == pytest.approx(expected.tconfint_mean(alpha=0.5))
    assert paired_means(-difference) == pytest.approx((-high, -low, p))


def test_paired_means_of_equal_differences_is_the_sign_test():
    """With none of n of the other sign, Clopper-Pearson allows a share of up to `upper`."""
    for n in (1, 4, 30):
        upper = binomtest(0, n).proportion_ci().high
        assert paired_means(np.full(n, 0.5)) == pytest.approx(
            (0.5 * (1 - 2 * upper), 0.5, min(1.0, 2 * 0.5**n))
        )
        assert paired_means(np.full(n, -0.5)) == pytest.approx(
            (-0.5, -0.5 * (1 - 2 * upper), min(1.0, 2 * 0.5**n))
        )
    assert paired_means(np.zeros(5)) == (0, 0, 1)


# ---- Holm ----------------------------------------------------------------------------------------


def test_holm_by_hand():
    cases = (
        ([0.03], [0.03]),
        ([0.01, 0.04, 0.03], [0.03, 0.06, 0.06]),  # 3 x 0.01; 2 x 0.03; max(1 x 0.04, 0.06)
        ([0.01, 0.02, 0.03, 0.04], [0.04, 0.06, 0.06, 0.06]),
        ([0.6, 0.5], [1.0, 1.0]),
        ([0.001, 0.001], [0.002, 0.002]),
        ([0.0, 1.0], [0.0, 1.0]),
        ([], []),
    )
    for p, adjusted in cases:
        assert holm(np.array(p)).tolist() == pytest.approx(adjusted), p


@given(st.lists(st.floats(0, 1), min_size=1, max_size=30))
def test_holm_agrees_with_its_definition(p):
    p = np.array(p)
    expected, running = np.empty(len(p)), 0.0
    for rank, i in enumerate(np.argsort(p, kind="stable")):
        running = max(running, (len(p) - rank) * p[i])
        expected[i] = min(1.0, running)
    adjusted = holm(p)
    assert np.allclose(adjusted, expected)
    assert (adjusted >= p - 1e-15).all()
    assert (holm(p[::-1]) == adjusted[::-1]).all()


def test_holm_keeps_the_family_wise_level():
    p = np.random.default_rng(4).random((2000, 10))
    rejected = np.array([holm(family).min() <= 0.05 for family in p]).mean()
    assert 0.035 < rejected < 0.065
