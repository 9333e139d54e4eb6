"""Kendall's tau between two orders, and its bootstrap interval."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kendalltau

from sensory_commutativity.statistics.orders import order_agreement

P = np.array([0.1, 0.3, 0.5, 0.7, 0.9])


def drawn(p: np.ndarray, n: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).random((n, len(p))) < p


def test_tau_is_that_of_the_column_means():
    a, b = drawn(P, 40, 0), drawn(P[[0, 2, 1, 4, 3]], 40, 1)
    found = order_agreement(a, b, np.random.default_rng(0), paired=False)
    assert found.tau == pytest.approx(kendalltau(a.mean(0), b.mean(0)).statistic)
    assert found.ci_low <= found.tau <= found.ci_high <= 1


def test_the_same_and_the_reverse_order():
    a = drawn(P, 2000, 0)
    assert order_agreement(a, a, np.random.default_rng(0), paired=True)[:2] == pytest.approx((1, 1))
    reverse = order_agreement(a, drawn(P[::-1], 2000, 1), np.random.default_rng(0), paired=False)
    assert reverse.tau == pytest.approx(-1) and reverse.ci_high < -0.9


def test_pairing_narrows_the_interval_where_units_are_shared():
    """Two measurements that fail on the same units agree in every resample; resampled apart they do not."""
    a = drawn(np.array([0.5, 0.52, 0.54]), 200, 3)
    paired, apart = (
        order_agreement(a, a, np.random.default_rng(1), paired=way) for way in (True, False)
    )
    assert paired.ci_low == pytest.approx(1) and apart.ci_low < 0.9


def test_what_is_all_tied_has_no_order():
    found = order_agreement(
        np.ones((10, 4)), drawn(P[:4], 10, 0), np.random.default_rng(0), paired=False
    )
    assert all(np.isnan(found))


def test_the_interval_covers():
    """95 % intervals for the tau of the true order (1) of well separated things nearly always hold it; for close ones they hold tau 1 as well."""
    held = 0
    for seed in range(40):
        a, b = drawn(P, 60, 2 * seed), drawn(P, 60, 2 * seed + 1)
        held += (
            order_agreement(a, b, np.random.default_rng(seed), paired=False, resamples=200).ci_high
            >= 0.999
        )
    assert held >= 34


@pytest.mark.parametrize(("shape", "paired"), [((5, 3), False), ((4, 4), True), ((5,), False)])
def test_other_things_cannot_be_compared(shape, paired):
    with pytest.raises(ValueError, match="same things"):
        order_agreement(np.zeros((5, 4)), np.zeros(shape), np.random.default_rng(0), paired)
