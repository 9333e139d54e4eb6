"""What is simulated: a method, a truth, and the band in which its coverage or rate should lie."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

MIDDLE = (0.94, 0.96)
"""Band of the coverage of a 95 % interval; chosen: a percent on either side."""
ENDS = (0.93, 1.0)
"""The same where the truth is near the end of its range. A discrete interval cannot have exactly
95 % there; it may have more."""


class Case(NamedTuple):
    """A simulation.

    Attributes
    ----------
    method : str
        Name of the interval or test, and of the situation.
    truth : float
        True value that an interval should hold; for a test its level.
    n : int
        Units in each data set.
    band : tuple of float
        Coverage or rate of rejections, from and to, that counts as kept.
    repeats : int
        Data sets.
    simulate : callable
        Generator, number of data sets -> in how many of them the interval holds the truth, or the
        test rejects.
    """

    method: str
    truth: float
    n: int
    band: tuple[float, float]
    repeats: int
    simulate: Callable[[np.random.Generator, int], int]


def run_case(
    case: Case, rng: np.random.Generator, repeats: int | None = None
) -> tuple[int, float, float, float, bool]:
    """Simulate a case.

    Returns
    -------
    repeats : int
    rate, low, high : float
        Coverage or rate of rejections, with its 95 % interval (Wilson).
    holds : bool
        Whether the interval meets the band, so that the simulation does not contradict it.
    """
    from ...statistics.proportions import wilson_interval

    repeats = case.repeats if repeats is None else repeats
    count = case.simulate(rng, repeats)
    low, high = (float(end) for end in wilson_interval(count, repeats))
    holds = low <= case.band[1] and high >= case.band[0]
    return repeats, count / repeats, low, high, bool(holds)
