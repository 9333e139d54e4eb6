"""Sequential ordering: capital, known cases, errors under continuous looking."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import betaln

from sensory_commutativity.statistics.sequential import (
    HIGHER,
    LOWER,
    TIED,
    UNDECIDED,
    SequentialOrder,
    log_capital_of_order,
    log_capital_of_tie,
)


def test_the_capital_is_that_of_a_mixture_of_bets():
    x, y = np.array([0, 3, 40]), np.array([0, 5, 2])
    expected = (x + y) * np.log(2) + betaln(x + 1, y + 1)
    np.testing.assert_allclose(log_capital_of_order(x, y), expected, atol=1e-9)
    assert log_capital_of_order(np.array(0), np.array(0)) == 0
    assert np.all(np.diff(log_capital_of_tie(0 * x, 0 * x, np.array([0, 50, 500]), 0.05)) > 0)
    assert log_capital_of_tie(np.array(60), np.array(0), np.array(40), 0.05) < 0


@pytest.mark.parametrize("p", [0.5, 0.9])
def test_the_mean_capital_of_a_true_hypothesis_is_at_most_1(p):
    """The mean of the capital after n units, over all outcomes of equal proportions."""
    rng = np.random.default_rng(0)
    a, b = rng.random((2, 20_000, 60)) < p
    order = np.exp(log_capital_of_order((a & ~b).sum(1), (b & ~a).sum(1)))
    assert order.mean() < 1.1
    margin = 0.3
    c = rng.random((20_000, 60)) < p - margin
    tie = np.exp(log_capital_of_tie((a & ~c).sum(1), (c & ~a).sum(1), (a == c).sum(1), margin))
    assert tie.mean() < 1.1


def test_clear_cases_are_decided_and_need_no_further_units():
    rng = np.random.default_rng(3)
    test = SequentialOrder(3, margin=0.1)
    while test.active.any():
        test.update(rng.random((1, 10, 3)) < [0.2, 1.0, 1.0])
    assert test.pairs == [(0, 1), (0, 2), (1, 2)]
    assert test.relations.tolist() == [[LOWER, LOWER, TIED]]
    assert test.units[0, 0] < test.units[0, 1] < 150
    before = test.units.copy()
    test.update(np.zeros((1, 100, 3), bool))
    assert (test.units == before).all()
    turned = SequentialOrder(2)
    turned.update(np.tile([True, False], (1, 50, 1)))
    assert turned.relations.tolist() == [[HIGHER]]
    assert SequentialOrder(2).relations.tolist() == [[UNDECIDED]]


@pytest.mark.parametrize(
    "probabilities",
    [
        [0.8, 0.8, 0.8, 0.8],  # no order is right
        [0.9, 0.85, 0.95, 0.9],  # differences of exactly the margin: no tie is right between them
    ],
)
def test_errors_stay_within_the_level_although_one_looks_after_every_ten_units(probabilities):
    rng, runs, margin = np.random.default_rng(4), 1000, 0.05
    test = SequentialOrder(4, alpha=0.1, margin=margin, runs=runs)
    for _ in range(150):
        test.update(rng.random((runs, 10, 4)) < probabilities)
    wrong = np.zeros(runs, bool)
    for k, (i, j) in enumerate(test.pairs):
        difference = probabilities[i] - probabilities[j]
        if difference <= 0:
            wrong |= test.relations[:, k] == HIGHER
        if difference >= 0:
            wrong |= test.relations[:, k] == LOWER
        if abs(difference) >= margin - 1e-12:
            wrong |= test.relations[:, k] == TIED
    assert wrong.mean() <= 0.1
    assert (test.relations != UNDECIDED).any()
