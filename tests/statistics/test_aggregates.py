"""Mean, median, interquartile mean and ratio of means with their intervals."""

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
    summarize,
)

pytestmark = pytest.mark.filterwarnings("error")

SKEWED = np.random.default_rng(1).exponential(3.0, 30)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


# ---- interquartile mean --------------------------------------------------------------------------


def test_interquartile_mean_by_hand():
    assert interquartile_mean([100, 1, 2, 3, 4, 5, 6, -100]) == 3.5  # drops two of eight per end
    assert interquartile_mean([1, 2, 300]) == 101  # drops none of three
    x = np.sort(SKEWED)
    assert interquartile_mean(SKEWED) == pytest.approx(x[7:23].mean())  # drops seven of thirty
    rows = rng().random((5, 8))
    expected = [interquartile_mean(row) for row in rows]
    assert interquartile_mean(rows, axis=1) == pytest.approx(expected)


# ---- bootstrap -----------------------------------------------------------------------------------


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
    percentiles = np.quantile(means, [0.025, 0.975])
    assert abs(percentiles[1] - high) > 0.06  # BCa is not the percentile interval here


def test_bootstrap_interval_is_reproducible_and_widens_with_the_confidence():
    first, second = (bootstrap_interval(SKEWED, np.mean, rng(3), 999) for _ in range(2))
    assert first == second
    wide, narrow = (bootstrap_interval(SKEWED, np.mean, rng(3), 999, c) for c in (0.99, 0.5))
    assert wide[0] < narrow[0] < SKEWED.mean() < narrow[1] < wide[1]


def test_bootstrap_interval_of_equal_values():
    assert bootstrap_interval([0.1] * 7, np.median, rng()) == (0.1, 0.1)
    assert bootstrap_interval([0.1] * 7, np.ptp, rng()) == (0, 0)


def test_bootstrap_interval_falls_back_to_percentiles():
    """Leaving out any one of 1, 1, 1, 1, 1, 5, 5 leaves the median at 1: no acceleration."""
    x = np.array([1.0, 1, 1, 1, 1, 5, 5])
    assert bootstrap_interval(x, np.median, rng()) == (1, 5)
    assert stats.binom.sf(3, 7, 2 / 7) > 0.025  # probability that four or more of seven are 5
    assert bootstrap_interval(x, np.median, rng(), confidence=0.5) == (1, 1)


def test_bootstrap_interval_accepts_a_statistic_without_axis():
    expected = bootstrap_interval(SKEWED, np.mean, rng(3), 99)
    assert bootstrap_interval(SKEWED, lambda x: x.mean(), rng(3), 99) == pytest.approx(expected)


def test_bootstrap_interval_has_its_coverage():
    for statistic in (np.mean, np.median, interquartile_mean):
        generator = rng(11)
        intervals = [
            bootstrap_interval(generator.normal(0, 2, 30), statistic, generator, 199, 0.8)
            for _ in range(250)
        ]
        coverage = np.mean([low < 0 < high for low, high in intervals])
        assert 0.72 < coverage < 0.85, statistic


# ---- summary -------------------------------------------------------------------------------------


def test_summary_holds_the_statistics_and_their_intervals():
    for confidence in (0.95, 0.5):
        summary, generator = summarize(SKEWED, rng(), 999, confidence), rng()
        assert (summary.n, summary.mean) == (30, SKEWED.mean())
        assert (summary.median, summary.iqm) == (np.median(SKEWED), interquartile_mean(SKEWED))
        mean_interval = DescrStatsW(SKEWED).tconfint_mean(alpha=1 - confidence)
        assert (summary.mean_low, summary.mean_high) == pytest.approx(mean_interval)
        for ends, statistic in (
            ((summary.median_low, summary.median_high), np.median),
            ((summary.iqm_low, summary.iqm_high), interquartile_mean),
        ):
            assert ends == bootstrap_interval(SKEWED, statistic, generator, 999, confidence)
    assert summarize([2.0] * 5, rng()) == (5, *[2.0] * 9)


# ---- ratio of means ------------------------------------------------------------------------------


def test_ratio_of_means_by_hand():
    # A quarter of the resamples of the first sample is 2, 2 and a quarter is 4, 4.
    assert ratio_of_means([2, 4], [1, 1], rng(), 999) == (3, 2, 4)
    assert ratio_of_means([2, 2, 2], [8, 8], rng()) == (0.25, 0.25, 0.25)
    assert ratio_of_means([2, 4], [-1, -1], rng(), 999) == (-3, -4, -2)


def test_ratio_of_means_agrees_with_a_naive_bootstrap():
    a, b = SKEWED + 1, rng(2).gamma(4.0, 1.0, 12)
    for confidence in (0.95, 0.5):
        generator = rng(4)
        result = ratio_of_means(a, b, generator, 20_000, confidence)
        means_a = generator.choice(a, (20_000, 30)).mean(axis=1)
        means_b = generator.choice(b, (20_000, 12)).mean(axis=1)
        ends = np.quantile(means_a / means_b, [0.5 - confidence / 2, 0.5 + confidence / 2])
        assert result.ratio == pytest.approx(a.mean() / b.mean())
        assert (result.ci_low, result.ci_high) == pytest.approx(ends, abs=0.02)


def test_ratio_of_means_has_its_coverage():
    generator, inside = rng(6), []
    for _ in range(300):
        a, b = generator.exponential(6, 30), generator.normal(3, 1, 40)
        ratio = ratio_of_means(a, b, generator, 199, 0.8)
        inside.append(ratio.ci_low < 2 < ratio.ci_high)
    assert 0.72 < np.mean(inside) < 0.84


def test_ratio_of_means_with_a_second_mean_near_zero():
    """A resample of 20 values has only zeros with probability 0.12 if 18 are 0, 0.0008 if 14."""
    two, six = (np.repeat([0.0, 1.0], [20 - k, k]) for k in (2, 6))
    a = np.linspace(1, 2, 20)
    assert ratio_of_means(a, two, rng()) == (pytest.approx(15), -math.inf, math.inf)
    assert np.isfinite(ratio_of_means(a, two, rng(), confidence=0.5)).all()  # 0.12 < 0.25
    assert np.isfinite(ratio_of_means(a, six, rng())).all()
    assert ratio_of_means(a, [-1, 2, -3, 3], rng())[1:] == (-math.inf, math.inf)
    assert ratio_of_means(a, [1, -2, 3, -3], rng())[1:] == (-math.inf, math.inf)
    with pytest.raises(ValueError, match="mean is not 0"):
        ratio_of_means([1, 2], [-1, 1], rng())


# ---- parts ---------------------------------------------------------------------------------------


def test_resampling_counts_are_those_of_draws_with_replacement():
    counts = resampling_counts(5, 20_000, rng())
    assert counts.shape == (20_000, 5)
    assert (counts.sum(axis=1) == 5).all()
    assert counts.mean(axis=0) == pytest.approx([1] * 5, abs=0.03)
    assert (counts == 0).mean() == pytest.approx(0.8**5, abs=0.01)


def test_percentile_interval():
    assert percentile_interval(np.arange(101.0), 0.9) == pytest.approx((5, 95))


def test_invalid_arguments_are_rejected():
    functions = (
        lambda x, **confidence: bootstrap_interval(x, np.mean, rng(), 9, **confidence),
        lambda x, **confidence: summarize(x, rng(), 9, **confidence),
        lambda x, **confidence: ratio_of_means(x, [1, 2], rng(), 9, **confidence),
        lambda x, **confidence: ratio_of_means([1, 2], x, rng(), 9, **confidence),
    )
    cases = (
        ([1.0], "at least 2"),
        ([[1.0, 2.0]], "one dimension"),
        ([1.0, np.nan], "not finite"),
    )
    for function in functions:
        for invalid, message in cases:
            with pytest.raises(ValueError, match=message):
                function(invalid)
        with pytest.raises(ValueError, match="confidence must lie between 0 and 1"):
            function([1, 1], confidence=95)
