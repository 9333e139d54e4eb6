"""Agreement of two rankings: Kendall's tau with a bootstrap interval over units."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import kendalltau

from .aggregates import percentile_interval, resampling_counts


class OrderAgreement(NamedTuple):
    """Kendall's tau-b of two rankings with its 95 % interval; NaN if one of them is all ties."""

    tau: float
    ci_low: float
    ci_high: float


def order_agreement(
    a: np.ndarray, b: np.ndarray, rng: np.random.Generator, paired: bool, resamples: int = 2_000
) -> OrderAgreement:
    """Kendall's tau-b between the column means of `a` and those of `b`.

    Parameters
    ----------
    a, b : bool or float (n, items), (m, items)
        Measurements: a row per unit, a column per item that is ranked. The items are the same.
    rng : Generator
    paired : bool
        Whether the rows of `a` and `b` are the same units. These are resampled together, otherwise
        each array on its own.
    resamples : int

    Returns
    -------
    OrderAgreement
        The interval is the percentile bootstrap over units. Resamples in which one ranking is all
        ties are dropped.

    Raises
    ------
    ValueError
        If the numbers of items differ, or, with `paired`, the numbers of units.
    """
    a, b = np.asarray(a, float), np.asarray(b, float)
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1] or (paired and len(a) != len(b)):
        raise ValueError(
            f"two rankings must be of the same items; got arrays of shapes {a.shape} and {b.shape}"
        )
    counts_a = resampling_counts(len(a), resamples, rng)
    counts_b = counts_a if paired else resampling_counts(len(b), resamples, rng)
    means_a, means_b = counts_a @ a / len(a), counts_b @ b / len(b)  # (resamples, items)
    taus = np.array([_tau(x, y) for x, y in zip(means_a, means_b, strict=True)])
    taus = taus[np.isfinite(taus)]
    interval = percentile_interval(taus, 0.95) if taus.size else (float("nan"), float("nan"))
    return OrderAgreement(_tau(a.mean(axis=0), b.mean(axis=0)), *interval)


def _tau(x: np.ndarray, y: np.ndarray) -> float:
    if np.ptp(x) == 0 or np.ptp(y) == 0:
        return float("nan")
    # Rounded, so that equal means whose sums were formed in another order are ties.
    return float(kendalltau(np.round(x, 9), np.round(y, 9)).statistic)
