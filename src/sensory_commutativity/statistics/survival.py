"""Times to an event that some runs never reach: right-censored data. How many steps until the task is learned?"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from .checks import fraction, sample


class SurvivalCurve(NamedTuple):
    """Kaplan-Meier estimate; arrays (k,), one row for time 0 and one for each distinct time at which a run reached the event or was lost."""

    time: np.ndarray
    at_risk: np.ndarray  # runs not yet there, just before this time
    events: np.ndarray  # runs that reached the event at this time
    survival: np.ndarray  # probability of not being there after this time
    ci_low: np.ndarray
    ci_high: np.ndarray


class LogRank(NamedTuple):
    """Outcome of a log-rank test of two groups, a and b."""

    statistic: (
        float  # standard normal under the null hypothesis; positive when a reaches the event sooner
    )
    p: float  # two-sided


def kaplan_meier(times: ArrayLike, observed: ArrayLike, confidence: float = 0.95) -> SurvivalCurve:
    """Kaplan-Meier estimate of the probability that a run has not reached the event, with pointwise log-log intervals.

    Parameters
    ----------
    times : float (n,)
        Time of the event or, for a run that never reached it, the time when it ended; >= 0.
    observed : bool (n,)
        Whether the event was reached.

    Returns
    -------
    SurvivalCurve
        The log-log interval is undefined where the estimate is 1 or 0. There, the ends are exact binomial ones (Clopper-Pearson) of the runs at risk:
        while nobody has reached the event, [(alpha / 2)^(1 / at risk), 1]; where nobody is left, 0 and the smaller of the upper end before and
        1 - (alpha / 2)^(1 / at risk). At time 0 all are at risk and the interval is [1, 1], by definition; if some run has the event at time 0, a
        second row with time 0 follows.
    """
    times, observed = _checked(times, observed)
    tail = (1 - fraction(confidence, "confidence")) / 2
    curve = stats.ecdf(_censored(times, observed)).sf
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # undefined at 0 and 1, see above
        interval = curve.confidence_interval(confidence, method="log-log")
    low, high = interval.low.probabilities, interval.high.probabilities

    survival = curve.probabilities
    at_risk = (times >= curve.quantiles[:, None]).sum(axis=1)
    events = (times[observed] == curve.quantiles[:, None]).sum(axis=1)
    nobody, everybody = survival == 1, survival == 0
    low = np.where(nobody, tail ** (1 / at_risk), np.where(everybody, 0.0, low))
    high = np.where(nobody, 1.0, np.where(everybody, 1 - tail ** (1 / at_risk), high))
    high = np.where(everybody, np.minimum(high, np.append(1.0, high[:-1])), high)

    columns = (curve.quantiles, at_risk, events, survival, low, high)
    return SurvivalCurve(
        *(
            np.append(first, column)
            for first, column in zip((0.0, len(times), 0, 1.0, 1.0, 1.0), columns, strict=True)
        )
    )


def median_time(time: ArrayLike, survival: ArrayLike) -> float:
    """First of the times (k,) of a survival curve at which at least half of the runs are there (survival <= 0.5); NaN if that is never reached."""
    reached = np.asarray(survival) <= 0.5 + 1e-12  # products of fractions: one half, up to rounding
    return float(np.asarray(time)[reached.argmax()]) if reached.any() else float("nan")


def log_rank(
    times_a: ArrayLike, observed_a: ArrayLike, times_b: ArrayLike, observed_b: ArrayLike
) -> LogRank:
    """Two-sided log-rank test of two groups; times and observed as in `kaplan_meier`.

    Statistic 0 and p 1 where the data cannot tell: nothing was observed, or at every event one of the groups has nobody at risk or all runs have it
    at once.
    """
    (times_a, observed_a), (times_b, observed_b) = (
        _checked(times_a, observed_a),
        _checked(times_b, observed_b),
    )
    reached = np.append(times_a[observed_a], times_b[observed_b])
    when, events = np.unique(reached, return_counts=True)
    risk_a, risk_b = ((times[:, None] >= when).sum(axis=0) for times in (times_a, times_b))
    if not ((risk_a > 0) & (risk_b > 0) & (events < risk_a + risk_b)).any():
        return LogRank(0.0, 1.0)
    test = stats.logrank(_censored(times_a, observed_a), _censored(times_b, observed_b))
    return LogRank(float(test.statistic), float(test.pvalue))


def _censored(times: np.ndarray, observed: np.ndarray) -> stats.CensoredData:
    return stats.CensoredData.right_censored(times, ~observed)


def _checked(times: ArrayLike, observed: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Times float (n,) and observed bool (n,), or ValueError."""
    times, observed = sample(times, "times", least=1), np.asarray(observed)
    if (times < 0).any():
        raise ValueError(
            f"times must not be negative: count them from the start of the run; got {times.min()}"
        )
    if observed.shape != times.shape or not np.isin(observed, (0, 1)).all():
        raise ValueError(
            f"observed must say yes or no for each of the {times.size} times; got {observed.dtype} of shape {observed.shape}"
        )
    return times, observed.astype(bool)
