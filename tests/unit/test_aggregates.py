"""statistics/aggregates.py: mean, median, interquartile mean, ratio of means."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from statsmodels.stats.weightstats import DescrStatsW

from sensory_commutativity.statistics.aggregates import (
    bootstrap_interval,
    interquartile_mean,
    percentile_interval,
    ratio_of_means,
    resampling_counts,
    summary,
)

pytestmark = pytest.mark.filterwarnings("error")

SKEWED = np.random.default_rng(1).exponential(3.0, 30)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


# ---- interquartile mean ----------------------------------------------------------------------------------------------------


def test_interquartile_mean_by_hand():
    assert (
        interquartile_mean([100, 1, 2, 3, 4, 5, 6, -100]) == 3.5
    )  # two of eight left out at either end
    assert interquartile_mean([1, 2, 300]) == 101  # of three, nothing
    x = np.sort(SKEWED)
    assert interquartile_mean(SKEWED) == pytest.approx(x[7:23].mean())  # seven of thirty


def test_interquartile_mean_along_an_axis():
    x = rng().random((5, 8))
    assert interquartile_mean(x, axis=1) == pytest.approx([interquartile_mean(row) for row in x])


# ---- bootstrap -------------------------------------------------------------------------------------------------------------


def test_bootstrap_interval_is_bca():
    """Against the definition of Efron (1987), with other resamples."""
    low, high = bootstrap_interval(SKEWED, np.mean, rng(), 20_000)
    means = rng(9).choice(SKEWED, (20_000, 30)).mean(axis=1)
    z0 = stats.norm.ppf((means < SKEWED.mean()).mean())
    left_out = np.array([np.delete(SKEWED, i).mean() for i in range(30)])
    d = left_out.mean() - left_out
    acceleration = (d**3).sum() / (6 * (d**2).sum() ** 1.5)
    z = z0 + stats.norm.ppf([0.025, 0.975])
    expected = np.quantile(means, stats.norm.cdf(z0 + z / (1 - acceleration * z)))
    assert (low, high) == pytest.approx(expected, abs=0.03)
    plain = np.quantile(means, [0.025, 0.975])
    assert abs(plain[1] - high) > 0.06  # BCa is not the percentile interval here


def test_bootstrap_interval_widens_with_confidence_and_repeats():
    assert bootstrap_interval(SKEWED, np.mean, rng(3), 999) == bootstrap_interval(
        SKEWED, np.mean, rng(3), 999
    )
    wide, narrow = (bootstrap_interval(SKEWED, np.mean, rng(3), 999, c) for c in (0.99, 0.5))
    assert wide[0] < narrow[0] < SKEWED.mean() < narrow[1] < wide[1]


def test_bootstrap_interval_of_equal_values():
    assert bootstrap_interval([0.1] * 7, np.median, rng()) == (0.1, 0.1)
    assert bootstrap_interval([0.1] * 7, np.ptp, rng()) == (0, 0)


def test_bootstrap_interval_falls_back_on_percentiles():
    """The median of 1, 1, 1, 1, 5, 5, 5 is 1 and leaving out any one value leaves it there: no acceleration."""
    x = np.array([1.0, 1, 1, 1, 1, 5, 5])
    assert bootstrap_interval(x, np.median, rng()) == (1, 5)
    assert stats.binom.sf(3, 7, 2 / 7) > 0.025  # how often four or more of seven are 5
    assert bootstrap_interval(x, np.median, rng(), confidence=0.5) == (1, 1)


def test_bootstrap_interval_takes_a_statistic_without_axis():
    assert bootstrap_interval(SKEWED, lambda x: x.mean(), rng(3), 99) == pytest.approx(
        bootstrap_interval(SKEWED, np.mean, rng(3), 99)
    )


@pytest.mark.parametrize(
    ("statistic", "truth"),
    [(np.mean, 0), (np.median, 0), (interquartile_mean, 0)],
    ids=["mean", "median", "iqm"],
)
def test_bootstrap_interval_covers_as_often_as_it_says(statistic, truth):
    generator = rng(11)
    intervals = [
        bootstrap_interval(generator.normal(0, 2, 30), statistic, generator, 199, 0.8)
        for _ in range(250)
    ]
    assert 0.72 < np.mean([low < truth < high for low, high in intervals]) < 0.85


# ---- summary ---------------------------------------------------------------------------------------------------------------


def test_summary():
    found = summary(SKEWED, rng(), 999)
    assert (found.n, found.mean, found.median, found.iqm) == (
        30,
        SKEWED.mean(),
        np.median(SKEWED),
        interquartile_mean(SKEWED),
    )
    assert (found.mean_low, found.mean_high) == pytest.approx(DescrStatsW(SKEWED).tconfint_mean())
    generator = rng()
    assert (found.median_low, found.median_high) == bootstrap_interval(
        SKEWED, np.median, generator, 999
    )
    assert (found.iqm_low, found.iqm_high) == bootstrap_interval(
        SKEWED, interquartile_mean, generator, 999
    )


def test_summary_at_another_confidence():
    found = summary(SKEWED, rng(), 999, 0.5)
    assert (found.mean_low, found.mean_high) == pytest.approx(
        DescrStatsW(SKEWED).tconfint_mean(alpha=0.5)
    )
    generator = rng()
    assert (found.median_low, found.median_high) == bootstrap_interval(
        SKEWED, np.median, generator, 999, 0.5
    )
    assert (found.iqm_low, found.iqm_high) == bootstrap_interval(
        SKEWED, interquartile_mean, generator, 999, 0.5
    )


def test_summary_of_equal_values():
    assert summary([2.0] * 5, rng()) == (5, *[2.0] * 9)


# ---- ratio of means --------------------------------------------------------------------------------------------------------


def test_ratio_of_means_by_hand():
    assert ratio_of_means([2, 4], [1, 1], rng(), 999) == (
        3,
        2,
        4,
    )  # a quarter of the resamples is 2, 2 and a quarter 4, 4
    assert ratio_of_means([2, 2, 2], [8, 8], rng()) == (0.25, 0.25, 0.25)
    assert ratio_of_means([2, 4], [-1, -1], rng(), 999) == (-3, -4, -2)


@pytest.mark.parametrize("confidence", [0.95, 0.5])
def test_ratio_of_means_against_a_plain_bootstrap(confidence):
    a, b, generator = SKEWED + 1, rng(2).gamma(4.0, 1.0, 12), rng(4)
    found = ratio_of_means(a, b, generator, 20_000, confidence)
    plain = generator.choice(a, (20_000, 30)).mean(axis=1) / generator.choice(b, (20_000, 12)).mean(
        axis=1
    )
    assert found.ratio == pytest.approx(a.mean() / b.mean())
    assert (found.ci_low, found.ci_high) == pytest.approx(
        np.quantile(plain, [0.5 - confidence / 2, 0.5 + confidence / 2]), abs=0.02
    )


def test_ratio_of_means_covers_as_often_as_it_says():
    generator = rng(6)
    found = [
        ratio_of_means(
            generator.exponential(6, 30), generator.normal(3, 1, 40), generator, 199, 0.8
        )
        for _ in range(300)
    ]
    assert 0.72 < np.mean([r.ci_low < 2 < r.ci_high for r in found]) < 0.84


def test_ratio_of_means_with_a_second_mean_near_zero():
    """With 2 of 20 values other than 0, a resample has none of them with probability 0.9^20 = 0.12; with 6 of 20, 0.0008."""
    two, six = (np.repeat([0.0, 1.0], [20 - k, k]) for k in (2, 6))
    a = np.linspace(1, 2, 20)
    assert ratio_of_means(a, two, rng()) == (pytest.approx(15), -math.inf, math.inf)
    assert np.isfinite(ratio_of_means(a, two, rng(), confidence=0.5)).all()  # 0.12 < 0.25
    assert np.isfinite(ratio_of_means(a, six, rng())).all()
    assert ratio_of_means(a, [-1, 2, -3, 3], rng())[1:] == (-math.inf, math.inf)
    assert ratio_of_means(a, [1, -2, 3, -3], rng())[1:] == (-math.inf, math.inf)


def test_a_ratio_to_nothing_is_refused():
    with pytest.raises(ValueError, match="mean is not 0"):
        ratio_of_means([1, 2], [-1, 1], rng())


# ---- parts -----------------------------------------------------------------------------------------------------------------


def test_resampling_counts_are_those_of_draws_with_replacement():
    counts = resampling_counts(5, 20_000, rng())
    assert counts.shape == (20_000, 5)
    assert (counts.sum(axis=1) == 5).all()
    assert counts.mean(axis=0) == pytest.approx([1] * 5, abs=0.03)
    assert (counts == 0).mean() == pytest.approx(0.8**5, abs=0.01)


def test_percentile_interval():
    assert percentile_interval(np.arange(101.0), 0.9) == pytest.approx((5, 95))


@pytest.mark.parametrize(
    "call",
    [
        lambda x: bootstrap_interval(x, np.mean, rng()),
        lambda x: summary(x, rng()),
        lambda x: ratio_of_means(x, [1, 2], rng()),
        lambda x: ratio_of_means([1, 2], x, rng()),
    ],
)
@pytest.mark.parametrize(
    ("bad", "says"),
    [([1.0], "at least 2"), ([[1.0, 2.0]], "one dimension"), ([1.0, np.nan], "not finite")],
)
def test_runs_that_are_refused(call, bad, says):
    with pytest.raises(ValueError, match=says):
        call(bad)


@pytest.mark.parametrize(
    "call",
    [
        lambda confidence: bootstrap_interval(SKEWED, np.mean, rng(), 9, confidence),
        lambda confidence: summary([1, 1], rng(), 9, confidence),
        lambda confidence: ratio_of_means(SKEWED, SKEWED, rng(), 9, confidence),
    ],
)
def test_confidence_is_a_fraction(call):
    with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
        call(95)
