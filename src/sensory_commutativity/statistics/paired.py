"""Comparing proportions that were counted on the same start situations: McNemar's test, with Holm's correction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest
from statsmodels.stats.multitest import multipletests


class McNemar(NamedTuple):
    """Outcome of a McNemar test of two paired yes/no measurements, a and b."""

    only_a: int  # pairs with a and not b
    only_b: int
    difference: float  # proportion of a minus proportion of b
    p: float  # exact, two-sided


def mcnemar(a: np.ndarray, b: np.ndarray) -> McNemar:
    """Exact two-sided McNemar test of two boolean arrays (n,) measured on the same n units.

    Under the null hypothesis of equal proportions a discordant pair falls either way with probability one half. Raises ValueError when the arrays
    differ in shape or are empty.
    """
    a, b = np.asarray(a, bool), np.asarray(b, bool)
    if a.shape != b.shape or a.size == 0:
        raise ValueError(
            f"a paired test needs two arrays of equal, non-zero length; got shapes {a.shape} and {b.shape}"
        )
    only_a, only_b = int((a & ~b).sum()), int((b & ~a).sum())
    discordant = only_a + only_b
    p = float(binomtest(only_a, discordant).pvalue) if discordant else 1.0
    return McNemar(only_a, only_b, (only_a - only_b) / a.size, p)


def paired_difference_interval(
    only_a: int, only_b: int, n: int, confidence: float = 0.95
) -> tuple[float, float]:
    """Interval for the difference of two paired proportions (Agresti and Min 2005: Wald after adding half a pair to each cell)."""
    from scipy.stats import norm

    z = float(norm.ppf(0.5 + confidence / 2))
    c, b, n = only_a + 0.5, only_b + 0.5, n + 2
    difference = (c - b) / n
    half = z * np.sqrt(c + b - (c - b) ** 2 / n) / n
    return max(-1.0, difference - half), min(1.0, difference + half)


def holm(p: np.ndarray) -> np.ndarray:
    """p-values of a family of tests adjusted by Holm's step-down method; the same shape, each at most 1."""
    p = np.asarray(p, float)
    return multipletests(p, method="holm")[1] if p.size else p
