"""Ratios of paired proportions: published numbers, coverage, level."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.statistics.ratios import compare_ratios, paired_ratio


def pairs(both: int, only_a: int, only_b: int, neither: int) -> tuple[np.ndarray, np.ndarray]:
    counts = [both, only_a, only_b, neither]
    return np.repeat([True, True, False, False], counts), np.repeat(
        [True, False, True, False], counts
    )


def simulate(rng: np.random.Generator, shape: tuple, p: float, q: float, depends: float):
    """Two dependent proportions p and q: with probability `depends` one draw decides both."""
    u = rng.random(shape)
    v = np.where(rng.random(shape) < depends, u, rng.random(shape))
    return u < p, v < q


def test_a_ratio_lies_in_its_interval_and_does_not_depend_on_units_with_neither():
    found = paired_ratio(*pairs(43, 8, 3, 10))
    assert found.ratio == pytest.approx(51 / 46)
    assert found.ci_low < found.ratio < found.ci_high
    assert paired_ratio(*pairs(43, 8, 3, 500)) == pytest.approx(found)
    turned = paired_ratio(*reversed(pairs(43, 8, 3, 10)))
    assert turned.ci_low == pytest.approx(1 / found.ci_high)


@pytest.mark.parametrize(("p", "q", "n"), [(0.6, 0.7, 50), (0.95, 0.99, 100), (0.97, 0.97, 300)])
def test_the_interval_covers_the_ratio(p, q, n):
    rng = np.random.default_rng(1)
    inside = 0
    for _ in range(2000):
        a, b = simulate(rng, (n,), p, q, 0.5)
        found = paired_ratio(a, b)
        inside += found.ci_low <= p / q <= found.ci_high
    assert 0.93 <= inside / 2000 <= 0.98


def test_equal_ratios_are_told_apart_no_more_often_than_the_level():
    rng = np.random.default_rng(2)
    rejected = 0
    for _ in range(2000):
        a = simulate(rng, (200,), 0.8, 0.9, 0.5)
        b = simulate(rng, (200,), 0.64, 0.72, 0.5)
        rejected += compare_ratios(a, b).p < 0.05
    assert rejected / 2000 < 0.065
    far = compare_ratios(pairs(700, 0, 300, 0), pairs(990, 5, 5, 0))
    assert far.difference < 0 and far.p < 1e-6


def test_what_never_varies_has_no_difference_and_an_interval_of_a_width():
    always = np.ones(1000, bool)
    assert compare_ratios((always, always), (always, always)).p == 1
    ratio, low, high = paired_ratio(always, always)
    assert ratio == 1 and 0.99 < low < 1 < high < 1.01
    never = paired_ratio(always, ~always)
    assert np.isnan(never.ratio) and never.ci_high == np.inf
    with pytest.raises(ValueError, match="equal, non-zero length"):
        paired_ratio(always, always[:3])
