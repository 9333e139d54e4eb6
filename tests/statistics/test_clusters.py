"""ROC curve, bootstrap over clusters, t-test of clusters."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from scipy.stats import ttest_1samp

from sensory_commutativity.statistics.clusters import (
    area_under_roc_curve,
    cluster_means,
    paired_cluster_difference,
    resample_clusters,
)

LABELS = pd.Series(["b", "a", "b", "c", "a", "b"], index=[7, 3, 9, 1, 4, 4])


def test_area_under_roc_curve_is_the_probability_of_the_right_order():
    """Of 2 x 3 pairs, 4 are in the right order and 1 is a tie."""
    scores = np.array([0.9, 0.4, 0.4, 0.1, 0.6])
    positive = np.array([True, True, False, False, False])
    assert area_under_roc_curve(scores, positive) == pytest.approx(4.5 / 6)
    assert area_under_roc_curve(-scores, positive) == pytest.approx(1.5 / 6)
    for constant in (np.ones(5, bool), np.zeros(5, bool)):
        assert math.isnan(area_under_roc_curve(scores, constant))


def test_area_under_roc_curve_agrees_with_the_curve():
    rng = np.random.default_rng(2)
    positive = rng.random(60) < 0.3
    scores = (rng.normal(size=60) + positive).round(1)  # with ties
    thresholds = np.append(np.unique(scores), np.inf)
    tpr = [(scores[positive] >= t).mean() for t in thresholds]
    fpr = [(scores[~positive] >= t).mean() for t in thresholds]
    area = np.trapezoid(tpr[::-1], fpr[::-1])
    assert area_under_roc_curve(scores, positive) == pytest.approx(area)


def test_resamples_draw_whole_clusters():
    clusters, counts = resample_clusters(LABELS, 4000, np.random.default_rng(0))
    assert [rows.tolist() for rows in clusters] == [[1, 4], [0, 2, 5], [3]]  # a, b, c
    assert counts.shape == (4000, 3) and (counts.sum(axis=1) == 3).all()
    assert counts.mean(axis=0) == pytest.approx([1, 1, 1], abs=0.05)
    repeated = resample_clusters(LABELS, 4000, np.random.default_rng(0))[1]
    assert np.array_equal(counts, repeated)


def test_cluster_means_are_those_of_the_resampled_rows():
    values = np.array([1.0, np.nan, 4.0, 8.0, 2.0, 5.0])
    clusters, counts = resample_clusters(LABELS, 50, np.random.default_rng(1))
    means = cluster_means(values, clusters, counts)
    for count, mean in zip(counts, means, strict=True):
        rows = np.concatenate([np.tile(c, k) for c, k in zip(clusters, count, strict=True)])
        assert mean == pytest.approx(np.nanmean(values[rows]))
    only_b = np.where(LABELS == "b", values, np.nan)
    with np.errstate(invalid="ignore"):
        means = cluster_means(only_b, clusters, counts)
    assert np.array_equal(np.isnan(means), counts[:, 1] == 0)


def test_cluster_t_test_of_equal_clusters_is_that_of_their_means():
    difference = np.random.default_rng(3).normal(0.4, 1, 12)
    labels = pd.Series(np.repeat(range(4), 3))
    result = paired_cluster_difference(difference, labels)
    expected = ttest_1samp(difference.reshape(4, 3).mean(axis=1), 0)
    assert (result.n, result.clusters) == (12, 4)
    assert result.mean == pytest.approx(difference.mean())
    assert result.p == pytest.approx(expected.pvalue)
    assert (result.ci_low, result.ci_high) == pytest.approx(expected.confidence_interval())


def test_cluster_t_test_weights_clusters_by_their_rows():
    """Sums 2 and 3 of clusters of 1 and 3 rows: weighted values 1 and 1.5, mean 5/4."""
    result = paired_cluster_difference(np.array([2.0, 1.0, 1.0, 1.0]), pd.Series([0, 1, 1, 1]))
    assert result.mean == pytest.approx(5 / 4)
    assert result.p == pytest.approx(ttest_1samp([1.0, 1.5], 0).pvalue)
    single = paired_cluster_difference(np.array([1.0, 3.0]), pd.Series(["a", "a"]))
    assert single[:2] == (2, 2) and np.isnan(single[2:4]).all() and single[4:] == (1, 1)
