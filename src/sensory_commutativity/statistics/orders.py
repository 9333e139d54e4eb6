"""Do two conditions put things in the same order? Kendall's tau with a bootstrap interval over shared units."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import kendalltau

from .aggregates import percentile_interval, resampling_counts


class OrderAgreement(NamedTuple):
    """Kendall's tau-b of two orders, with its 95 % interval; NaN where one of them ties everything."""

    tau: float
    ci_low: float
    ci_high: float


def order_agreement(
    a: np.ndarray, b: np.ndarray, rng: np.random.Generator, paired: bool, resamples: int = 2_000
) -> OrderAgreement:
    """Kendall's tau-b between the column means of `a` and of `b`.

    Parameters
    ----------
    a, b : bool or float (units, things)
        What was measured on each unit; the things are the same in both, e.g. degrees of freedom.
    paired : bool
        Whether the rows are the same units, which are then resampled together; else each is resampled alone.

    Returns
    -------
    OrderAgreement
        The interval is the percentile bootstrap's over units; resamples in which everything is tied are left out.
    """
    a, b = np.asarray(a, float), np.asarray(b, float)
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1] or (paired and len(a) != len(b)):
        raise ValueError(
            f"two orders of the same things are needed; got arrays of shapes {a.shape} and {b.shape}"
        )
    counts = resampling_counts(len(a), resamples, rng)
    others = counts if paired else resampling_counts(len(b), resamples, rng)
    taus = np.array(
        [_tau(x, y) for x, y in zip(counts @ a / len(a), others @ b / len(b), strict=True)]
    )
    taus = taus[np.isfinite(taus)]
    interval = percentile_interval(taus, 0.95) if taus.size else (float("nan"), float("nan"))
    return OrderAgreement(_tau(a.mean(axis=0), b.mean(axis=0)), *interval)


def _tau(x: np.ndarray, y: np.ndarray) -> float:
    if np.ptp(x) == 0 or np.ptp(y) == 0:
        return float("nan")
    return float(
        kendalltau(np.round(x, 9), np.round(y, 9)).statistic
    )  # rounded: sums in another order are ties still
