"""Rank correlation of two measures, with a permutation test."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import kendalltau, spearmanr


class RankCorrelation(NamedTuple):
    """Rank correlations of two measures of the same n items."""

    n: int
    spearman: float
    kendall: float
    p: float  # two-sided, permutation test of Spearman's coefficient


def rank_correlation(
    x: np.ndarray, y: np.ndarray, rng: np.random.Generator, permutations: int = 9_999
) -> RankCorrelation:
    """Spearman's rho with a permutation test, and Kendall's tau-b, of two arrays (n,).

    The coefficients are NaN and p is 1 if one of the arrays is constant.
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    if np.ptp(x) == 0 or np.ptp(y) == 0:
        return RankCorrelation(len(x), float("nan"), float("nan"), 1.0)
    rho = float(spearmanr(x, y).statistic)
    shuffled = np.array([spearmanr(x, rng.permutation(y)).statistic for _ in range(permutations)])
    p = (1 + int((np.abs(shuffled) >= abs(rho) - 1e-12).sum())) / (1 + permutations)
    return RankCorrelation(len(x), rho, float(kendalltau(x, y).statistic), p)
