"""statistics/paired.py: McNemar's test, the interval that goes with it, Holm's correction."""

from __future__ import annotations

import gc
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest
from statsmodels.stats import contingency_tables

from sensory_commutativity.statistics.paired import holm, mcnemar, paired_difference_interval


@pytest.fixture(scope="module", autouse=True)
def quick_holm():
    """statsmodels collects garbage in every call of multipletests, 0.1 s each in a large process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gc, "collect", lambda *_: 0)
        yield


def pairs(both: int, only_a: int, only_b: int, neither: int) -> tuple[np.ndarray, np.ndarray]:
    """Two boolean arrays with these counts."""
    cells = (
        [(True, True)] * both
        + [(True, False)] * only_a
        + [(False, True)] * only_b
        + [(False, False)] * neither
    )
    return tuple(np.array(cells, bool).reshape(-1, 2).T)


# ---- McNemar ---------------------------------------------------------------------------------------------------------------


def test_mcnemar_by_hand():
    found = mcnemar(*pairs(both=3, only_a=5, only_b=1, neither=1))
    assert (found.only_a, found.only_b) == (5, 1)
    assert found.difference == pytest.approx(8 / 10 - 4 / 10)
    assert found.p == pytest.approx(2 * (1 + 6) / 2**6)  # 0 or 1 of 6 fair coins, on either side


@pytest.mark.parametrize(
    ("only_a", "only_b", "p"),
    [(0, 0, 1.0), (1, 0, 1.0), (4, 4, 1.0), (6, 0, 2 / 64), (0, 10, 2 / 1024)],
)
def test_mcnemar_known_values(only_a, only_b, p):
    assert mcnemar(*pairs(2, only_a, only_b, 2)).p == pytest.approx(p)


@given(st.integers(0, 40), st.integers(0, 40), st.integers(0, 40), st.integers(0, 40))
def test_mcnemar_against_scipy_and_statsmodels(both, only_a, only_b, neither):
    a, b = pairs(both, only_a, only_b, neither)
    if not len(a):
        return
    found = mcnemar(a, b)
    if only_a + only_b:
        assert found.p == pytest.approx(binomtest(only_a, only_a + only_b, 0.5).pvalue)
        assert found.p == pytest.approx(
            contingency_tables.mcnemar([[both, only_a], [only_b, neither]], exact=True).pvalue
        )
    assert found.difference == pytest.approx(a.mean() - b.mean())
    mirrored = mcnemar(b, a)
    assert (mirrored.only_a, mirrored.only_b, mirrored.p) == (only_b, only_a, found.p)
    assert mirrored.difference == -found.difference


def test_mcnemar_uses_the_pairing():
    a = np.array([True, False] * 10)
    assert mcnemar(a, a).p == 1.0
    assert mcnemar(a, ~a)[:2] == (10, 10)


def test_mcnemar_takes_zeros_and_ones():
    assert mcnemar(np.array([1, 1, 0]), np.array([0, 1, 0])) == mcnemar(
        np.array([True, True, False]), np.array([False, True, False])
    )


@pytest.mark.parametrize(("a", "b"), [([True], [True, False]), ([], []), ([[True]], [True])])
def test_mcnemar_refuses_what_is_not_paired(a, b):
    with pytest.raises(ValueError, match="paired"):
        mcnemar(np.array(a, bool), np.array(b, bool))


def test_mcnemar_keeps_its_level():
    """Under the null hypothesis at most 5 % of the tests may find something at 5 %; an exact test stays below."""
    rng = np.random.default_rng(20)
    p = np.array([mcnemar(rng.random(60) < 0.4, rng.random(60) < 0.4).p for _ in range(400)])
    for level in (0.05, 0.2, 0.5):
        found = (p <= level).mean()
        assert level / 3 < found < level + 2.5 * math.sqrt(level * (1 - level) / 400)


# ---- the interval of the difference ----------------------------------------------------------------------------------------


def test_interval_by_hand():
    low, high = paired_difference_interval(5, 1, 10)
    middle, half = (
        4 / 12,
        1.959963984540054 * math.sqrt(7 - 16 / 12) / 12,
    )  # half a pair more in each cell: 5.5, 1.5, 12
    assert (low, high) == pytest.approx((middle - half, middle + half))


@given(st.integers(0, 50), st.integers(0, 50), st.integers(0, 50))
def test_interval_holds_the_difference_and_mirrors(only_a, only_b, rest):
    n = only_a + only_b + rest
    if not n:
        return
    low, high = paired_difference_interval(only_a, only_b, n)
    assert -1 <= low < high <= 1
    assert low <= (only_a - only_b) / (n + 2) <= high
    assert paired_difference_interval(only_b, only_a, n) == pytest.approx((-high, -low))
    wider = paired_difference_interval(only_a, only_b, n, 0.99)
    assert wider[0] <= low and wider[1] >= high


def test_interval_is_cut_off_at_one():
    assert paired_difference_interval(2, 0, 2)[1] == 1.0
    assert paired_difference_interval(0, 2, 2)[0] == -1.0


def test_interval_covers_as_often_as_it_says():
    """The true difference is 0.2."""
    rng, n = np.random.default_rng(8), 80
    cells = rng.multinomial(n, [0.3, 0.3, 0.1, 0.3], 4000)
    inside = 0
    for _, only_a, only_b, _ in cells:
        low, high = paired_difference_interval(only_a, only_b, n)
        inside += low <= 0.2 <= high
    assert 0.94 < inside / 4000 < 0.965


# ---- Holm ------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("p", "adjusted"),
    [
        ([0.03], [0.03]),
        ([0.01, 0.04, 0.03], [0.03, 0.06, 0.06]),  # 3 x 0.01; 2 x 0.03; max(1 x 0.04, 0.06)
        ([0.01, 0.02, 0.03, 0.04], [0.04, 0.06, 0.06, 0.06]),
        ([0.6, 0.5], [1.0, 1.0]),
        ([0.001, 0.001], [0.002, 0.002]),
        ([0.0, 1.0], [0.0, 1.0]),
        ([], []),
    ],
)
def test_holm_by_hand(p, adjusted):
    assert holm(np.array(p)).tolist() == pytest.approx(adjusted)


@given(st.lists(st.floats(0, 1), min_size=1, max_size=30))
def test_holm_against_its_definition(p):
    p = np.array(p)
    adjusted, order, running = np.empty(len(p)), np.argsort(p, kind="stable"), 0.0
    for rank, i in enumerate(order):
        running = max(running, (len(p) - rank) * p[i])
        adjusted[i] = min(1.0, running)
    found = holm(p)
    assert np.allclose(found, adjusted)
    assert (found >= p - 1e-15).all()
    assert (holm(p[::-1]) == found[::-1]).all()


def test_holm_keeps_the_family_wise_level():
    p = np.random.default_rng(4).random((2000, 10))
    found = np.array([holm(family).min() <= 0.05 for family in p]).mean()
    assert 0.035 < found < 0.065
