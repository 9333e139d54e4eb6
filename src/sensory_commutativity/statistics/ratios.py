"""Ratios of proportions that were measured on the same units."""

from __future__ import annotations

from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from .proportions import NORMAL_975


class PairedRatio(NamedTuple):
    """Ratio of two proportions measured on the same units, with its interval."""

    ratio: float
    ci_low: float
    ci_high: float


def paired_ratio(a: np.ndarray, b: np.ndarray, confidence: float = 0.95) -> PairedRatio:
    """Ratio of the proportion of `a` to that of `b`, bool (n,), measured on the same n units.

    Bonett and Price 2006, https://doi.org/10.1002/sim.2440: Wilson's intervals of both proportions,
    narrowed by their dependence. The ratio is NaN and its upper end infinite if `b` is never true.

    Raises
    ------
    ValueError
        If the arrays differ in shape or are empty.
    """
    a, b = _check_pair(a, b)
    z = NORMAL_975 if confidence == 0.95 else NormalDist().inv_cdf(0.5 + confidence / 2)
    both, only_a, only_b = int((a & b).sum()), int((a & ~b).sum()), int((~a & b).sum())
    x, y, n = both + only_a, both + only_b, both + only_a + only_b
    if not y:
        return PairedRatio(float("nan"), 0.0, float("inf"))
    # Units with neither do not count: the ratio does not depend on them.
    p, q = (x + 1) / (n + 2), (y + 1) / (n + 2)
    joint = np.sqrt((only_a + only_b + 2) / ((x + 1) * (y + 1)))
    apart = np.sqrt((1 - p) / (x + 1)) + np.sqrt((1 - q) / (y + 1))
    low_a, high_a = _wilson(x, n, z * joint / apart)
    low_b, high_b = _wilson(y, n, z * joint / apart)
    high = high_a / low_b if low_b else float("inf")
    return PairedRatio(x / y, low_a / high_b, high)


def _wilson(successes: int, n: int, z: float) -> tuple[float, float]:
    p, square = successes / n, z * z
    half = z * np.sqrt(square + 4 * n * p * (1 - p))
    middle, below = 2 * n * p + square, 2 * (n + square)
    return max(0.0, (middle - half) / below), min(1.0, (middle + half) / below)


class RatioComparison(NamedTuple):
    """Comparison of two such ratios."""

    difference: float  # of their logarithms
    z: float
    p: float  # two-sided


def compare_ratios(
    a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray]
) -> RatioComparison:
    """Test that two ratios of proportions, all measured on the same units, are equal.

    Parameters
    ----------
    a, b : pairs of bool (n,)
        Numerator and denominator of a ratio.

    Returns
    -------
    RatioComparison
        By the delta method on the logarithms, with the covariances of all four. Half a unit is
        added to each proportion, so that none is 0. If the four have no variance, z is 0 and p 1.
    """
    columns = np.stack([*_check_pair(*a), *_check_pair(*b)], axis=1).astype(float)
    n = len(columns)
    means = (columns.sum(axis=0) + 0.5) / (n + 0.5)
    weights = np.array([1, -1, -1, 1]) / means
    difference = float(np.log(means) @ [1, -1, -1, 1])
    variance = float(np.var(columns @ weights)) / n
    if variance <= 1e-18:
        return RatioComparison(difference, 0.0, 1.0)
    from scipy import stats

    z = difference / np.sqrt(variance)
    return RatioComparison(difference, float(z), float(2 * stats.norm.sf(abs(z))))


def _check_pair(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b = np.asarray(a, bool), np.asarray(b, bool)
    if a.shape != b.shape or a.ndim != 1 or a.size == 0:
        raise ValueError(
            "a ratio of paired proportions needs two arrays of equal, non-zero length; got shapes "
            f"{a.shape} and {b.shape}"
        )
    return a, b
