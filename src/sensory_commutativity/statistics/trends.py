"""Proportions in several groups: trend over ordered groups, and two groups within strata."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import norm


class Trend(NamedTuple):
    """Result of a test for trend."""

    slope: float  # least-squares slope of the proportion per unit of score
    z: float
    p: float  # two-sided


def cochran_armitage(successes: ArrayLike, n: ArrayLike, scores: ArrayLike) -> Trend:
    """Cochran-Armitage test for a linear trend of independent proportions.

    Parameters
    ----------
    successes, n : int (k,)
        Successes and trials of each of the k groups.
    scores : float (k,)
        The quantity that orders the groups, e.g. a dose.

    Returns
    -------
    Trend
        slope 0, z 0 and p 1 if all trials have the same outcome or all scores are equal.
    """
    k, n, scores = (np.asarray(x, float) for x in (successes, n, scores))
    total, pooled = n.sum(), k.sum() / n.sum()
    centred = scores - (n * scores).sum() / total
    spread = (n * centred**2).sum()
    if pooled in (0.0, 1.0) or spread == 0:
        return Trend(0.0, 0.0, 1.0)
    statistic = (k * centred).sum()
    z = statistic / np.sqrt(pooled * (1 - pooled) * spread)
    return Trend(float(statistic / spread), float(z), float(2 * norm.sf(abs(z))))


class StratifiedComparison(NamedTuple):
    """Result of a comparison of two groups within strata."""

    odds_ratio: float  # Mantel-Haenszel, group a over group b
    p: float  # two-sided, Cochran-Mantel-Haenszel


def mantel_haenszel(
    successes_a: ArrayLike, n_a: ArrayLike, successes_b: ArrayLike, n_b: ArrayLike
) -> StratifiedComparison:
    """Cochran-Mantel-Haenszel test of two independent groups over k strata.

    Successes and trials are int (k,). Strata without both outcomes carry no information and are
    dropped; the odds ratio and p are 1 if none is left.
    """
    from statsmodels.stats.contingency_tables import StratifiedTable  # takes a second to import

    outcomes_a = [successes_a, np.subtract(n_a, successes_a)]
    outcomes_b = [successes_b, np.subtract(n_b, successes_b)]
    tables = np.array([outcomes_a, outcomes_b], float)  # (2, 2, k)
    informative = (tables.sum(axis=0) > 0).all(axis=0)  # both outcomes occur in the stratum
    if not informative.any():
        return StratifiedComparison(1.0, 1.0)
    table = StratifiedTable(tables[:, :, informative])
    return StratifiedComparison(float(table.oddsratio_pooled), float(table.test_null_odds().pvalue))
