"""Times to an event that some runs never reach (right-censored data)."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .checks import check_fraction, check_sample


class SurvivalCurve(NamedTuple):
    """Kaplan-Meier estimate, arrays (k,).

    One row for time 0 and one for each distinct time at which a run reached the event or was
    censored.
    """

    time: np.ndarray
    at_risk: np.ndarray  # runs without the event, just before this time
    events: np.ndarray  # runs that reach the event at this time
    survival: np.ndarray  # probability of not having reached the event by this time
    ci_low: np.ndarray
    ci_high: np.ndarray


class LogRank(NamedTuple):
    """Result of a log-rank test of two groups, a and b."""

    statistic: float  # standard normal if the groups are equal; positive if a is sooner
    p: float  # two-sided


def kaplan_meier(times: ArrayLike, observed: ArrayLike, confidence: float = 0.95) -> SurvivalCurve:
    """Kaplan-Meier estimate of the probability of not having reached the event.

    Parameters
    ----------
    times : float (n,)
        Time of the event or, for a run that never reached it, the time at which the run ended;
        >= 0.
    observed : bool (n,)
        Whether the event was reached.
    confidence : float

    Returns
    -------
    SurvivalCurve
        Pointwise log-log intervals. These are undefined where the estimate is 1 or 0; there the
        ends are exact binomial ones (Clopper-Pearson) of the runs at risk. With alpha = 1 -
        confidence: before the first event, [(alpha / 2)^(1 / at_risk), 1]; after the last run, 0
        and the smaller of the previous upper end and 1 - (alpha / 2)^(1 / at_risk). At time 0 the
        interval is [1, 1] by definition. If a run has the event at time 0, a second row with
        time 0 follows.
    """
    times, observed = _check_times(times, observed)
    tail = (1 - check_fraction(confidence, "confidence")) / 2
    curve = stats.ecdf(_censor(times, observed)).sf
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # undefined at 0 and 1, see above
        interval = curve.confidence_interval(confidence, method="log-log")
    low, high = interval.low.probabilities, interval.high.probabilities

    survival = curve.probabilities
    at_risk = (times >= curve.quantiles[:, None]).sum(axis=1)
    events = (times[observed] == curve.quantiles[:, None]).sum(axis=1)
    none_reached, all_reached = survival == 1, survival == 0
    low = np.where(none_reached, tail ** (1 / at_risk), np.where(all_reached, 0.0, low))
    high = np.where(none_reached, 1.0, np.where(all_reached, 1 - tail ** (1 / at_risk), high))
    high = np.where(all_reached, np.minimum(high, np.append(1.0, high[:-1])), high)

    start = (0.0, len(times), 0, 1.0, 1.0, 1.0)
    columns = (curve.quantiles, at_risk, events, survival, low, high)
    return SurvivalCurve(*(np.append(*pair) for pair in zip(start, columns, strict=True)))


def median_time(time: ArrayLike, survival: ArrayLike) -> float:
    """First time of a survival curve (k,) by which at least half of the runs reached the event.

    NaN if there is none.
    """
    reached = np.asarray(survival) <= 0.5 + 1e-12  # one half, up to the rounding of products
    return float(np.asarray(time)[reached.argmax()]) if reached.any() else float("nan")


def log_rank(
    times_a: ArrayLike, observed_a: ArrayLike, times_b: ArrayLike, observed_b: ArrayLike
) -> LogRank:
    """Two-sided log-rank test of two groups; times and observed as in :func:`kaplan_meier`.

    The statistic is 0 and p is 1 where the data cannot decide: no event was observed, or at every
    event either one group has no run at risk or all runs have the event.
    """
    times_a, observed_a = _check_times(times_a, observed_a)
    times_b, observed_b = _check_times(times_b, observed_b)
    reached = np.append(times_a[observed_a], times_b[observed_b])
    event_times, events = np.unique(reached, return_counts=True)
    risk_a, risk_b = ((times[:, None] >= event_times).sum(axis=0) for times in (times_a, times_b))
    if not ((risk_a > 0) & (risk_b > 0) & (events < risk_a + risk_b)).any():
        return LogRank(0.0, 1.0)
    test = stats.logrank(_censor(times_a, observed_a), _censor(times_b, observed_b))
    return LogRank(float(test.statistic), float(test.pvalue))


def _censor(times: np.ndarray, observed: np.ndarray) -> stats.CensoredData:
    return stats.CensoredData.right_censored(times, ~observed)


def _check_times(times: ArrayLike, observed: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Convert to times float (n,) and observed bool (n,). Raises ValueError."""
    times, observed = check_sample(times, "times", minimum=1), np.asarray(observed)
    if (times < 0).any():
        raise ValueError(f"times must not be negative, they start with the run; got {times.min()}")
    if observed.shape != times.shape or not np.isin(observed, (0, 1)).all():
        raise ValueError(
            f"observed must be true or false for each of the {times.size} times; "
            f"got {observed.dtype} of shape {observed.shape}"
        )
    return times, observed.astype(bool)
