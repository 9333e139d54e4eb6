"""How many runs does a comparison need? Power of the two-sided t-test of two groups of equal size and variance.

The power is that of the equivalent F test: the square of a noncentral t is a noncentral F. statsmodels' TTestIndPower gives the same numbers where
it gives any, but it is NaN for some everyday inputs (d = 2.5, n = 30, alpha = 0.05; statsmodels 0.15, by scipy.special.nctdtr), and its solver then
stops at a wrong answer without a word (d = 1.21 instead of 1.31 for n = 30, alpha = 0.0001).
"""

from __future__ import annotations

import math

from scipy import stats
from scipy.optimize import brentq

from .checks import fraction

MOST_RUNS = 1_000_000
"""Runs per group beyond which `runs_needed` says infinity; chosen: far beyond what anyone trains."""

_LARGEST_EFFECT = 1e6  # power is 1 for any n >= 2 and any alpha in use; noncentral distributions are accurate up to here (chosen)
_SMALLEST_EFFECT = 1e-9  # power is alpha; scipy's noncentral F is wrong at exactly 0


def power_of_t_test(d: float, n: float, alpha: float) -> float:
    """Probability of p < alpha when the means differ by `d` standard deviations and both groups have `n` >= 2 runs."""
    fraction(alpha, "alpha")
    if math.isnan(d) or not n >= 2:
        raise ValueError(
            f"power needs an effect size and at least 2 runs in each group; got d = {d}, n = {n}"
        )
    d = min(abs(d), _LARGEST_EFFECT)
    if d < _SMALLEST_EFFECT:
        return float(alpha)
    df = 2 * (n - 1)
    return float(stats.ncf.sf(stats.t.isf(alpha / 2, df) ** 2, 1, df, n / 2 * d**2))


def detectable_effect(n: float, alpha: float, power: float = 0.8) -> float:
    """Smallest effect size d that `n` runs in each group find with probability `power` > alpha."""
    _check_power(alpha, power)
    return float(brentq(lambda d: power_of_t_test(d, n, alpha) - power, 0, _LARGEST_EFFECT))


def runs_needed(d: float, alpha: float, power: float = 0.8) -> float:
    """Smallest whole number of runs in each group, at least 2, that finds effect size `d` with probability `power` > alpha; inf beyond MOST_RUNS."""
    _check_power(alpha, power)

    def missing(n: float) -> float:
        return power_of_t_test(d, n, alpha) - power

    if missing(2) >= 0:
        return 2.0
    if missing(MOST_RUNS) < 0:
        return math.inf
    return float(
        math.ceil(brentq(missing, 2, MOST_RUNS) - 1e-6)
    )  # less than the root finder's error is not another run


def _check_power(alpha: float, power: float) -> None:
    if not fraction(alpha, "alpha") < fraction(power, "power"):
        raise ValueError(
            f"a test at level {alpha} has at least that power for any effect; ask for more than {power}"
        )
