"""Wilson's interval."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest, norm

from sensory_commutativity.statistics.proportions import wilson_interval

Z2 = 1.959963984540054**2


def test_known_values():
    half = 0.5 * math.sqrt(Z2 / (10 + Z2))
    cases = (
        (0, 10, 0.0, Z2 / (10 + Z2)),
        (10, 10, 10 / (10 + Z2), 1.0),
        (5, 10, 0.5 - half, 0.5 + half),
        (1, 1, 1 / (1 + Z2), 1.0),
        (81, 263, 0.2552699, 0.3662205),  # this and the next three: Newcombe 1998, table I
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
        (10_000, 10_000, 0.99962, 1.0),  # as the docstring says
    )
    for successes, n, *expected in cases:
        interval = wilson_interval(np.array([successes]), np.array([n]))
        assert np.ravel(interval) == pytest.approx(expected, abs=6e-5), (successes, n)


@given(
    st.integers(1, 500).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))),
    st.sampled_from([0.8, 0.9, 0.95, 0.99]),
)
def test_agrees_with_the_formula_and_scipy(counts, confidence):
    k, n = counts
    low, high = (float(x) for x in wilson_interval(np.array(k), np.array(n), confidence))
    z, p = norm.ppf(0.5 + confidence / 2), k / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    assert (low, high) == pytest.approx((middle - half, middle + half), abs=1e-12)
    expected = binomtest(k, n).proportion_ci(confidence, method="wilson")
    assert (low, high) == pytest.approx((expected.low, expected.high), abs=1e-12)
    assert 0 <= low <= p <= high <= 1


def test_arrays_keep_their_shape():
    low, high = wilson_interval(np.array([1, 5, 9]), np.array([10, 10, 10]))
    assert low.shape == high.shape == (3,)
    assert (np.diff(low) > 0).all() and (np.diff(high) > 0).all()
    assert low[0] == pytest.approx(1 - high[2])  # failures mirror successes


def test_coverage():
    p = np.linspace(0.02, 0.98, 97)
    for n in (30, 200, 1000):
        k = np.arange(n + 1)
        low, high = wilson_interval(k, np.full(n + 1, n))
        covers = (low[:, None] <= p) & (p <= high[:, None])
        coverage = (covers * binom.pmf(k[:, None], n, p)).sum(axis=0)  # exact
        assert 0.945 < coverage.mean() < 0.96, n
        assert coverage.min() > 0.90, n
