"""Power of the two-sided t-test of two groups of equal size and variance.

It is computed from the equivalent F test: the square of a noncentral t is a noncentral F.
statsmodels' TTestIndPower gives the same numbers where it gives any. But it returns NaN for some
ordinary inputs (d = 2.5, n = 30, alpha = 0.05; statsmodels 0.15, because of scipy.special.nctdtr),
and its solver then silently stops at a wrong value (d = 1.21 instead of 1.31 for n = 30,
alpha = 0.0001).
"""

from __future__ import annotations

import math

from scipy import stats
from scipy.optimize import brentq

from .checks import check_fraction

MAX_RUNS = 1_000_000
"""Runs per group beyond which :func:`runs_needed` returns infinity; chosen: more than anyone
trains."""

_LARGEST_EFFECT = 1e6
"""Chosen: the power is 1 for any n >= 2 and usual alpha, and scipy is still accurate here."""
_SMALLEST_EFFECT = 1e-9
"""Chosen: the power is alpha, and scipy's noncentral F is wrong at exactly 0."""
_ROOT_TOLERANCE = 1e-6
"""Runs; chosen: above the error of the root finder. A smaller fraction is not another run."""


def power_of_t_test(d: float, n: float, alpha: float) -> float:
    """Probability of p < alpha for an effect size `d` and `n` >= 2 runs in each group.

    The effect size is the difference of the means in standard deviations.
    """
    check_fraction(alpha, "alpha")
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
    """Smallest effect size that `n` runs in each group detect with probability `power` > alpha."""
    _check_power(alpha, power)
    return float(brentq(lambda d: power_of_t_test(d, n, alpha) - power, 0, _LARGEST_EFFECT))


def runs_needed(d: float, alpha: float, power: float = 0.8) -> float:
    """Smallest number of runs in each group that detects effect size `d` with probability `power`.

    A whole number from 2 to MAX_RUNS, or infinity. `power` must exceed `alpha`.
    """
    _check_power(alpha, power)

    def excess_power(n: float) -> float:
        return power_of_t_test(d, n, alpha) - power

    if excess_power(2) >= 0:
        return 2.0
    if excess_power(MAX_RUNS) < 0:
        return math.inf
    return float(math.ceil(brentq(excess_power, 2, MAX_RUNS) - _ROOT_TOLERANCE))


def _check_power(alpha: float, power: float) -> None:
    if not check_fraction(alpha, "alpha") < check_fraction(power, "power"):
        raise ValueError(
            f"a test at level {alpha} has at least that power for any effect; "
            f"ask for more than {power}"
        )
