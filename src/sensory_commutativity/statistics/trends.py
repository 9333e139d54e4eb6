"""Does a proportion rise or fall with something? Trend over ordered groups, and two groups compared within strata."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import norm
from statsmodels.stats.contingency_tables import StratifiedTable


class Trend(NamedTuple):
    """Outcome of a test for trend."""

    slope: float  # least-squares slope of the proportion per unit of score
    z: float
    p: float  # two-sided


def cochran_armitage(successes: np.ndarray, n: np.ndarray, scores: np.ndarray) -> Trend:
    """Cochran-Armitage test for a linear trend of independent proportions.

    Parameters
    ----------
    successes, n : int (k,)
        Counts of each of the k groups.
    scores : float (k,)
        What orders them, e.g. the number of objects.

    Returns
    -------
    Trend
        slope 0, z 0 and p 1 where all groups have all successes or none: there is no trend to see.
    """
    successes, n, scores = (np.asarray(x, float) for x in (successes, n, scores))
    total, pooled = n.sum(), successes.sum() / n.sum()
    centred = scores - (n * scores).sum() / total
    spread = (n * centred**2).sum()
    if pooled in (0.0, 1.0) or spread == 0:
        return Trend(0.0, 0.0, 1.0)
    statistic = (successes * centred).sum()
    z = statistic / np.sqrt(pooled * (1 - pooled) * spread)
    return Trend(float(statistic / spread), float(z), float(2 * norm.sf(abs(z))))


class StratifiedComparison(NamedTuple):
    """Outcome of comparing two groups within strata."""

    odds_ratio: float  # Mantel-Haenszel, group a over group b
    p: float  # two-sided, Cochran-Mantel-Haenszel


def mantel_haenszel(
    successes_a: np.ndarray, n_a: np.ndarray, successes_b: np.ndarray, n_b: np.ndarray
) -> StratifiedComparison:
    """Cochran-Mantel-Haenszel test of two independent groups over k strata; counts are int (k,)."""
    tables = np.array(
        [
            [successes_a, np.subtract(n_a, successes_a)],
            [successes_b, np.subtract(n_b, successes_b)],
        ],
        float,
    )  # (2, 2, k)
    informative = (tables.sum(axis=0) > 0).all(
        axis=0
    )  # strata in which something commuted and something did not
    if not informative.any():
        return StratifiedComparison(1.0, 1.0)
    table = StratifiedTable(tables[:, :, informative])
    return StratifiedComparison(float(table.oddsratio_pooled), float(table.test_null_odds().pvalue))
