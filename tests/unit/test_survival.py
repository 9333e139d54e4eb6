"""statistics/survival.py: times to an event that some runs never reach."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from statsmodels.duration.survfunc import SurvfuncRight, survdiff

from sensory_commutativity.statistics.survival import (
    SurvivalCurve,
    kaplan_meier,
    log_rank,
    median_time,
)

pytestmark = pytest.mark.filterwarnings("error")

# Weeks of remission of leukaemia with 6-mercaptopurine and with placebo (Freireich et al. 1963), the textbooks' example; + is censored.
TREATED = "6 6 6 6+ 7 9+ 10 10+ 11+ 13 16 17+ 19+ 20+ 22 23 25+ 32+ 32+ 34+ 35+"
PLACEBO = "1 1 2 2 3 4 4 5 5 8 8 8 8 11 11 12 12 15 17 22 23"


def median_of(curve: SurvivalCurve) -> float:
    return median_time(curve.time, curve.survival)


def parse(text: str) -> tuple[np.ndarray, np.ndarray]:
    return np.array([float(word.rstrip("+")) for word in text.split()]), np.array(
        [not word.endswith("+") for word in text.split()]
    )


def simulated(seed: int, n: int, scale: float, end: float = 10.0) -> tuple[np.ndarray, np.ndarray]:
    """Times in whole units, so that there are ties; runs end at `end`."""
    times = np.ceil(np.random.default_rng(seed).exponential(scale, n))
    return np.minimum(times, end), times <= end


# ---- Kaplan-Meier ----------------------------------------------------------------------------------------------------------


def test_kaplan_meier_of_the_textbooks():
    curve = kaplan_meier(*parse(TREATED))
    at = {t: (n, d, round(s, 3)) for t, n, d, s in zip(*curve[:4], strict=True)}
    assert at[0] == (21, 0, 1)
    assert at[6] == (21, 3, 0.857)
    assert at[7] == (17, 1, 0.807)
    assert at[9] == (16, 0, 0.807)
    assert [at[t][2] for t in (10, 13, 16, 22, 23, 35)] == [
        0.753,
        0.690,
        0.627,
        0.538,
        0.448,
        0.448,
    ]
    assert at[35] == (1, 0, 0.448)
    assert median_of(curve) == 23
    assert median_of(kaplan_meier(*parse(PLACEBO))) == 8


def test_kaplan_meier_by_hand():
    """Four runs: events at 2 and 5, one lost at 3, one never there by 8."""
    curve = kaplan_meier([5, 2, 8, 3], [1, 1, 0, 0])
    assert curve.time.tolist() == [0, 2, 3, 5, 8]
    assert curve.at_risk.tolist() == [4, 4, 3, 2, 1]
    assert curve.events.tolist() == [0, 1, 0, 1, 0]
    assert curve.survival == pytest.approx([1, 3 / 4, 3 / 4, 3 / 8, 3 / 8])
    variance = 1 / (4 * 3) + 1 / (2 * 1)  # Greenwood's sum at 5
    spread = 1.959963984540054 * math.sqrt(variance) / abs(math.log(3 / 8))
    assert (curve.ci_low[3], curve.ci_high[3]) == pytest.approx(
        ((3 / 8) ** math.exp(spread), (3 / 8) ** math.exp(-spread))
    )


@pytest.mark.parametrize(
    "data", [parse(TREATED), parse(PLACEBO), simulated(1, 60, 6), simulated(2, 30, 30)]
)
def test_kaplan_meier_against_statsmodels(data):
    curve, other = kaplan_meier(*data), SurvfuncRight(*data)
    events = curve.events > 0
    assert curve.time[events] == pytest.approx(other.surv_times)
    assert curve.survival[events] == pytest.approx(other.surv_prob)
    assert curve.at_risk[events] == pytest.approx(other.n_risk)
    assert curve.events[events] == pytest.approx(other.n_events)
    assert (np.diff(curve.survival) <= 0).all() and (np.diff(curve.ci_high) <= 1e-12).all()
    assert (curve.ci_low <= curve.survival).all() and (curve.survival <= curve.ci_high).all()


def test_intervals_follow_the_confidence():
    wide, narrow = (kaplan_meier(*parse(TREATED), confidence) for confidence in (0.99, 0.5))
    assert (wide.ci_low[1:] < narrow.ci_low[1:]).all() and (
        wide.ci_high[1:] > narrow.ci_high[1:]
    ).all()


def test_nobody_reached():
    """Thirty runs without success: the exact binomial interval of the failures is [0.884, 1]."""
    curve = kaplan_meier([7.0] * 30, [False] * 30)
    assert curve.time.tolist() == [0, 7]
    assert curve.at_risk.tolist() == [30, 30]
    assert curve.survival.tolist() == curve.ci_high.tolist() == [1, 1]
    assert curve.ci_low == pytest.approx([1, stats.binomtest(30, 30).proportion_ci().low])
    assert math.isnan(median_of(curve))


def test_losses_before_the_first_event_leave_fewer_to_tell():
    curve = kaplan_meier([1, 2, 9], [False, False, True])
    assert curve.survival.tolist() == [1, 1, 1, 0]
    assert curve.ci_low.tolist() == pytest.approx([1, 0.025 ** (1 / 3), 0.025 ** (1 / 2), 0])


def test_all_reached_at_once():
    curve = kaplan_meier([4.0] * 30, [True] * 30)
    assert curve.survival.tolist() == [1, 0]
    assert (curve.ci_low[1], curve.ci_high[1]) == pytest.approx(
        tuple(stats.binomtest(0, 30).proportion_ci())
    )
    assert median_of(curve) == 4


def test_all_reached_one_by_one():
    """The last one alone would leave anything up to 0.975 possible; the time before says more."""
    curve = kaplan_meier(np.arange(1.0, 11), [True] * 10)
    assert curve.survival == pytest.approx(np.linspace(1, 0, 11))
    assert (curve.ci_low[-1], curve.ci_high[-1]) == (0, curve.ci_high[-2])
    assert curve.ci_high[-2] < 0.5


def test_an_event_at_time_zero_has_its_own_row():
    curve = kaplan_meier([0, 3], [True, True])
    assert curve.time.tolist() == [0, 0, 3]
    assert curve.survival.tolist() == [1, 0.5, 0]
    assert median_of(curve) == 0


@pytest.mark.parametrize("n", range(2, 60, 2))
def test_the_median_is_found_where_exactly_half_are_left(n):
    """Also where products of fractions leave a little more than one half."""
    assert (
        median_of(kaplan_meier(np.append(np.arange(1, n + 1), n + 1), [True] * n + [False]))
        == n // 2 + 1
    )
    assert (
        median_of(kaplan_meier(np.append(np.arange(1, n), n), [True] * (n - 1) + [False])) == n // 2
    )


def test_a_median_that_is_not_reached():
    assert math.isnan(median_of(kaplan_meier([1, 2, 2, 2], [1, 0, 0, 0])))


def test_intervals_cover_as_often_as_they_say():
    rng, inside = np.random.default_rng(5), 0
    for _ in range(400):
        times, end = rng.exponential(1, 40), rng.uniform(0.5, 3, 40)
        curve = kaplan_meier(np.minimum(times, end), times <= end, 0.9)
        row = np.searchsorted(curve.time, 0.6, side="right") - 1
        inside += curve.ci_low[row] < math.exp(-0.6) < curve.ci_high[row]
    assert 0.86 < inside / 400 < 0.94


# ---- log-rank --------------------------------------------------------------------------------------------------------------


def test_log_rank_of_the_textbooks():
    found = log_rank(*parse(TREATED), *parse(PLACEBO))
    assert found.statistic**2 == pytest.approx(16.79, abs=0.005)
    assert found.statistic < 0  # the treated stay in remission longer
    assert log_rank(*parse(PLACEBO), *parse(TREATED)) == pytest.approx((-found.statistic, found.p))


@pytest.mark.parametrize("seed", range(4))
def test_log_rank_against_statsmodels(seed):
    a, b = simulated(seed, 30, 5), simulated(seed + 10, 20, 8)
    found = log_rank(*a, *b)
    group = np.repeat([0, 1], [30, 20])
    chi_squared, p = survdiff(np.append(a[0], b[0]), np.append(a[1], b[1]), group)
    assert (found.statistic**2, found.p) == pytest.approx((chi_squared, p))


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ("7+ 7+ 7+", "7+ 7+"),  # nothing observed
        ("5+ 5+ 5+", " ".join(f"{t}" for t in range(6, 55))),  # a is lost before b's first event
        (" ".join(f"{t}" for t in range(6, 55)), "5+ 5+"),
        ("4 4 4", "4 4"),  # all at once
    ],
)
def test_log_rank_where_data_cannot_tell(a, b):
    assert log_rank(*parse(a), *parse(b)) == (0, 1)


def test_log_rank_of_two_runs_by_hand():
    """One of the two has the event when both are at risk: observed 1, expected 1/2, variance 1/4."""
    assert log_rank([5], [True], [5], [False]) == (1, pytest.approx(2 * stats.norm.sf(1)))


def test_log_rank_where_one_group_never_gets_there():
    found = log_rank(*parse("3 4 5 6 7 8"), *parse("9+ 9+ 9+ 9+ 9+ 9+"))
    assert found.statistic > 0
    assert found.p == pytest.approx(
        survdiff(
            np.array([3, 4, 5, 6, 7, 8] + [9] * 6), np.repeat([1, 0], 6), np.repeat([0, 1], 6)
        )[1]
    )


# ---- what is refused -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("times", "observed", "says"),
    [
        ([], [], "at least 1"),
        ([[1.0]], [[True]], "one dimension"),
        ([1.0, np.nan], [True, False], "not finite"),
        ([1.0, -2.0], [True, True], "negative"),
        ([1.0, 2.0], [True], "each of the 2 times"),
        ([1.0, 2.0], [1.0, np.nan], "yes or no"),
    ],
)
def test_times_that_are_refused(times, observed, says):
    with pytest.raises(ValueError, match=says):
        kaplan_meier(times, observed)
    with pytest.raises(ValueError, match=says):
        log_rank(times, observed, [1.0], [True])
    with pytest.raises(ValueError, match=says):
        log_rank([1.0], [True], times, observed)


def test_confidence_is_a_fraction():
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        kaplan_meier([1.0], [True], 95)
