"""The simulations of the calibration: few repeats here, all of them by make calibration."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from sensory_commutativity.studies.calibration import intervals, levels
from sensory_commutativity.studies.calibration.cases import ENDS, MIDDLE, Case, run_case
from sensory_commutativity.studies.calibration.tables.calibration import calibration, cases


def test_every_simulation_runs_and_has_a_name_of_its_own():
    keys = [(case.method, case.truth, case.n) for case in cases()]
    assert len(keys) == len(set(keys)) > 35
    for case in cases():
        repeats, rate, low, high, _ = run_case(case, np.random.default_rng(0), 3)
        assert repeats == 3 and 0 <= low <= rate <= high <= 1, case.method


def test_intervals_of_proportions_keep_what_they_promise():
    for case in intervals.interval_cases():
        if case.method.startswith(("Wilson", "Tango")):
            repeats = case.repeats if case.method.startswith("Wilson") else 1000
            assert run_case(case, np.random.default_rng(1), repeats)[4], case


def test_an_interval_or_a_test_that_is_wrong_does_not_hold():
    def too_short(rng: np.random.Generator, repeats: int) -> int:
        return int(rng.binomial(repeats, 0.9))

    for band in (MIDDLE, ENDS):
        case = Case("too short", 0.5, 400, band, 4000, too_short)
        assert not run_case(case, np.random.default_rng(0))[4]
    liberal = Case("liberal", 0.05, 400, levels.EXACT, 4000, partial(rate, 0.07))
    timid = Case("timid", 0.05, 400, levels.ABOUT, 4000, partial(rate, 0.03))
    exact = timid._replace(band=levels.EXACT)
    assert not run_case(liberal, np.random.default_rng(0))[4]
    assert not run_case(timid, np.random.default_rng(0))[4]
    assert run_case(exact, np.random.default_rng(0))[4]


def rate(p: float, rng: np.random.Generator, repeats: int) -> int:
    return int(rng.binomial(repeats, p))


def test_the_interval_that_was_replaced_would_be_found(monkeypatch):
    """Agresti and Min 2005: half a pair added to each cell, too short near 1."""
    from sensory_commutativity.statistics import paired

    def wald(only_a: int, only_b: int, n: int) -> tuple[float, float]:
        a, b, total = only_a + 0.5, only_b + 0.5, n + 2
        half = 1.96 * np.sqrt(a + b - (a - b) ** 2 / total) / total
        return (a - b) / total - half, (a - b) / total + half

    monkeypatch.setattr(paired, "paired_difference_interval", wald)
    (case,) = [c for c in intervals.interval_cases() if "0.995 and 1" in c.method]
    assert not run_case(case, np.random.default_rng(0))[4]


def test_the_table_has_the_columns_that_others_read(default_config):
    assert calibration.column_names == [
        "method", "truth", "n", "repeats", "coverage_or_rate", "low", "high", "holds"
    ]  # fmt: skip
    batched = calibration(default_config)
    assert batched.units == len(cases())
    first = batched.compute(0, 1)
    assert first["method"].tolist() == [cases()[0].method]
    assert first.equals(batched.compute(0, 1)), "a random stream of its own"


@pytest.mark.parametrize("p", intervals.PROPORTIONS)
def test_the_coverage_of_wilson_by_the_binomial_distribution(p):
    """Exact, without simulation."""
    from scipy.stats import binom

    from sensory_commutativity.statistics.proportions import wilson_interval

    k, n = np.arange(401), 400
    low, high = wilson_interval(k, np.full(401, n))
    coverage = binom.pmf(k, n, p)[(low <= p) & (p <= high)].sum()
    assert coverage > 0.93
