"""Statistics of rows in clusters: rows of a cluster depend on each other, clusters do not."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import stats

from .aggregates import resampling_counts
from .paired import paired_means


def area_under_roc_curve(scores: np.ndarray, positive: np.ndarray) -> float:
    """Area under the ROC curve of `scores`, float (n,), as a predictor of `positive`, bool (n,).

    It is the probability that a positive row has a larger score than a negative one; ties count
    one half. NaN unless there are rows of both kinds.
    """
    if positive.all() or not positive.any():
        return float("nan")
    u = stats.mannwhitneyu(scores[positive], scores[~positive]).statistic
    return float(u / (positive.sum() * (~positive).sum()))


def resample_clusters(
    labels: pd.Series, resamples: int, rng: np.random.Generator
) -> tuple[list[np.ndarray], np.ndarray]:
    """Draw bootstrap resamples of whole clusters.

    Parameters
    ----------
    labels : Series (n,)
        The cluster of each row.
    resamples : int
    rng : Generator

    Returns
    -------
    clusters : list of int arrays
        Row numbers of each cluster, clusters in ascending order of their labels.
    counts : int (resamples, clusters)
        How often each resample draws each cluster.
    """
    indices = labels.reset_index(drop=True).groupby(labels.to_numpy()).indices
    clusters = list(indices.values())
    return clusters, resampling_counts(len(clusters), resamples, rng)


def cluster_means(
    values: np.ndarray, clusters: Sequence[np.ndarray], counts: np.ndarray
) -> np.ndarray:
    """Compute the mean of `values` in each resample of clusters, leaving out NaN.

    Parameters
    ----------
    values : float (n,)
    clusters, counts
        As :func:`resample_clusters` returns them.

    Returns
    -------
    float (resamples,)
        NaN, with numpy's warning, for a resample without a finite value.
    """
    sums = np.array([np.nansum(values[rows]) for rows in clusters])
    sizes = np.array([np.isfinite(values[rows]).sum() for rows in clusters])
    return (counts @ sums) / (counts @ sizes)


class ClusterComparison(NamedTuple):
    """Result of a t-test of the mean of rows in clusters."""

    n: int  # rows
    mean: float  # of all rows
    ci_low: float
    ci_high: float
    clusters: int
    p: float  # two-sided


def paired_cluster_difference(difference: np.ndarray, labels: pd.Series) -> ClusterComparison:
    """Student's t-test that the mean of paired differences is 0, with clusters as units.

    Parameters
    ----------
    difference : float (n,)
    labels : Series (n,)
        The cluster of each row.

    Returns
    -------
    ClusterComparison
        Clusters count by their number of rows, so that the mean is that of all rows; see
        :func:`.paired.paired_means`. With a single cluster the interval is NaN and p is 1.
    """
    groups = pd.Series(difference).groupby(labels.to_numpy())
    n, mean = len(difference), float(difference.mean())
    if groups.ngroups < 2:
        return ClusterComparison(n, mean, np.nan, np.nan, groups.ngroups, 1.0)
    weighted = (groups.sum() * groups.ngroups / n).to_numpy()  # their mean is that of all rows
    low, high, p = paired_means(weighted)
    return ClusterComparison(n, mean, low, high, groups.ngroups, p)
