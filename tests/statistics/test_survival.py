"""Times to an event that some runs never reach."""

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

# Weeks of remission of leukaemia with 6-mercaptopurine and with placebo (Freireich et al. 1963),
# the example of many textbooks; + is censored.
TREATED = "6 6 6 6+ 7 9+ 10 10+ 11+ 13 16 17+ 19+ 20+ 22 23 25+ 32+ 32+ 34+ 35+"
PLACEBO = "1 1 2 2 3 4 4 5 5 8 8 8 8 11 11 12 12 15 17 22 23"


def median_of(curve: SurvivalCurve) -> float:
    return median_time(curve.time, curve.survival)


def parse(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Times, and whether the event was observed."""
    words = text.split()
    times = np.array([float(word.rstrip("+")) for word in words])
    return times, np.array([not word.endswith("+") for word in words])


def simulate(seed: int, n: int, scale: float, end: float = 10.0) -> tuple[np.ndarray, np.ndarray]:
    """Times in whole units, so that there are ties; runs end at `end`."""
    times = np.ceil(np.random.default_rng(seed).exponential(scale, n))
    return np.minimum(times, end), times <= end


# ---- Kaplan-Meier --------------------------------------------------------------------------------


def test_kaplan_meier_of_the_textbook_example():
    curve = kaplan_meier(*parse(TREATED))
    rows = {t: (n, d, round(s, 3)) for t, n, d, s in zip(*curve[:4], strict=True)}
    assert rows[0] == (21, 0, 1)
    assert rows[6] == (21, 3, 0.857)
    assert rows[7] == (17, 1, 0.807)
    assert rows[9] == (16, 0, 0.807)
    survival = [0.753, 0.690, 0.627, 0.538, 0.448, 0.448]
    assert [rows[t][2] for t in (10, 13, 16, 22, 23, 35)] == survival
    assert rows[35] == (1, 0, 0.448)
    assert median_of(curve) == 23
    assert median_of(kaplan_meier(*parse(PLACEBO))) == 8


def test_kaplan_meier_by_hand():
    """Four runs: events at 2 and 5, one censored at 3, one without the event at 8."""
    curve = kaplan_meier([5, 2, 8, 3], [1, 1, 0, 0])
    assert curve.time.tolist() == [0, 2, 3, 5, 8]
    assert curve.at_risk.tolist() == [4, 4, 3, 2, 1]
    assert curve.events.tolist() == [0, 1, 0, 1, 0]
    assert curve.survival == pytest.approx([1, 3 / 4, 3 / 4, 3 / 8, 3 / 8])
    variance = 1 / (4 * 3) + 1 / (2 * 1)  # Greenwood's sum at 5
    spread = 1.959963984540054 * math.sqrt(variance) / abs(math.log(3 / 8))
    ends = ((3 / 8) ** math.exp(spread), (3 / 8) ** math.exp(-spread))
    assert (curve.ci_low[3], curve.ci_high[3]) == pytest.approx(ends)


def test_kaplan_meier_agrees_with_statsmodels():
    for data in (parse(TREATED), parse(PLACEBO), simulate(1, 60, 6), simulate(2, 30, 30)):
        curve, expected = kaplan_meier(*data), SurvfuncRight(*data)
        events = curve.events > 0
        assert curve.time[events] == pytest.approx(expected.surv_times)
        assert curve.survival[events] == pytest.approx(expected.surv_prob)
        assert curve.at_risk[events] == pytest.approx(expected.n_risk)
        assert curve.events[events] == pytest.approx(expected.n_events)
        assert (np.diff(curve.survival) <= 0).all() and (np.diff(curve.ci_high) <= 1e-12).all()
        assert (curve.ci_low <= curve.survival).all()
        assert (curve.survival <= curve.ci_high).all()


def test_intervals_widen_with_the_confidence():
    wide, narrow = (kaplan_meier(*parse(TREATED), confidence) for confidence in (0.99, 0.5))
    assert (wide.ci_low[1:] < narrow.ci_low[1:]).all()
    assert (wide.ci_high[1:] > narrow.ci_high[1:]).all()


def test_no_run_reaches_the_event():
    """Thirty runs without success: the exact binomial interval of the failures is [0.884, 1]."""
    curve = kaplan_meier([7.0] * 30, [False] * 30)
    assert curve.time.tolist() == [0, 7]
    assert curve.at_risk.tolist() == [30, 30]
    assert curve.survival.tolist() == curve.ci_high.tolist() == [1, 1]
    assert curve.ci_low == pytest.approx([1, stats.binomtest(30, 30).proportion_ci().low])
    assert math.isnan(median_of(curve))


def test_censoring_before_the_first_event_widens_the_interval():
    curve = kaplan_meier([1, 2, 9], [False, False, True])
    assert curve.survival.tolist() == [1, 1, 1, 0]
    assert curve.ci_low.tolist() == pytest.approx([1, 0.025 ** (1 / 3), 0.025 ** (1 / 2), 0])


def test_all_runs_reach_the_event():
    """One by one, the last run alone would allow up to 0.975; the previous upper end is smaller."""
    at_once = kaplan_meier([4.0] * 30, [True] * 30)
    assert at_once.survival.tolist() == [1, 0]
    expected = tuple(stats.binomtest(0, 30).proportion_ci())
    assert (at_once.ci_low[1], at_once.ci_high[1]) == pytest.approx(expected)
    assert median_of(at_once) == 4
    one_by_one = kaplan_meier(np.arange(1.0, 11), [True] * 10)
    assert one_by_one.survival == pytest.approx(np.linspace(1, 0, 11))
    assert (one_by_one.ci_low[-1], one_by_one.ci_high[-1]) == (0, one_by_one.ci_high[-2])
    assert one_by_one.ci_high[-2] < 0.5


def test_event_at_time_zero_has_its_own_row():
    curve = kaplan_meier([0, 3], [True, True])
    assert curve.time.tolist() == [0, 0, 3]
    assert curve.survival.tolist() == [1, 0.5, 0]
    assert median_of(curve) == 0


def test_median_is_the_time_at_which_exactly_half_are_left():
    """Also where products of fractions are slightly larger than one half."""
    for n in range(2, 60, 2):
        odd = kaplan_meier(np.append(np.arange(1, n + 1), n + 1), [True] * n + [False])
        even = kaplan_meier(np.append(np.arange(1, n), n), [True] * (n - 1) + [False])
        assert (median_of(odd), median_of(even)) == (n // 2 + 1, n // 2)
    assert math.isnan(median_of(kaplan_meier([1, 2, 2, 2], [1, 0, 0, 0])))


def test_intervals_have_their_coverage():
    rng, inside = np.random.default_rng(5), 0
    for _ in range(400):
        times, end = rng.exponential(1, 40), rng.uniform(0.5, 3, 40)
        curve = kaplan_meier(np.minimum(times, end), times <= end, 0.9)
        row = np.searchsorted(curve.time, 0.6, side="right") - 1
        inside += curve.ci_low[row] < math.exp(-0.6) < curve.ci_high[row]
    assert 0.86 < inside / 400 < 0.94


# ---- log-rank ------------------------------------------------------------------------------------


def test_log_rank_of_the_textbook_example():
    result = log_rank(*parse(TREATED), *parse(PLACEBO))
    assert result.statistic**2 == pytest.approx(16.79, abs=0.005)
    assert result.statistic < 0  # the treated stay in remission longer
    swapped = log_rank(*parse(PLACEBO), *parse(TREATED))
    assert swapped == pytest.approx((-result.statistic, result.p))


def test_log_rank_agrees_with_statsmodels():
    pairs = [(simulate(seed, 30, 5), simulate(seed + 10, 20, 8)) for seed in range(4)]
    pairs.append((parse("3 4 5 6 7 8"), parse("9+ 9+ 9+ 9+ 9+ 9+")))  # b never reaches the event
    for a, b in pairs:
        result = log_rank(*a, *b)
        group = np.repeat([0, 1], [len(a[0]), len(b[0])])
        expected = survdiff(np.append(a[0], b[0]), np.append(a[1], b[1]), group)
        assert (result.statistic**2, result.p) == pytest.approx(expected)
    assert result.statistic > 0


def test_log_rank_where_the_data_cannot_decide():
    late = " ".join(f"{t}" for t in range(6, 55))
    cases = {
        "no event observed": ("7+ 7+ 7+", "7+ 7+"),
        "a is censored before the first event of b": ("5+ 5+ 5+", late),
        "b is censored before the first event of a": (late, "5+ 5+"),
        "all at once": ("4 4 4", "4 4"),
    }
    for name, (a, b) in cases.items():
        assert log_rank(*parse(a), *parse(b)) == (0, 1), name


def test_log_rank_of_two_runs_by_hand():
    """One of two runs at risk has the event: observed 1, expected 1/2, variance 1/4."""
    assert log_rank([5], [True], [5], [False]) == (1, pytest.approx(2 * stats.norm.sf(1)))


# ---- invalid arguments ---------------------------------------------------------------------------


def test_invalid_times_are_rejected():
    cases = (
        ([], [], "at least 1"),
        ([[1.0]], [[True]], "one dimension"),
        ([1.0, np.nan], [True, False], "not finite"),
        ([1.0, -2.0], [True, True], "negative"),
        ([1.0, 2.0], [True], "each of the 2 times"),
        ([1.0, 2.0], [1.0, np.nan], "true or false"),
    )
    for times, observed, message in cases:
        with pytest.raises(ValueError, match=message):
            kaplan_meier(times, observed)
        with pytest.raises(ValueError, match=message):
            log_rank(times, observed, [1.0], [True])
        with pytest.raises(ValueError, match=message):
            log_rank([1.0], [True], times, observed)
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        kaplan_meier([1.0], [True], 95)
