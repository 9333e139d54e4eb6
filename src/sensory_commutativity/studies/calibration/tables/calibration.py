"""Coverage of the intervals and rates of the tests of all tables, simulated."""

from __future__ import annotations

import pandas as pd

from ....seeding import generator
from ....storage.columns import BOOL, FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Batched, Expected, table
from ..cases import Case, run_case
from ..intervals import interval_cases
from ..levels import level_cases


def cases() -> list[Case]:
    """All simulations, in the order of the rows."""
    return [*interval_cases(), *level_cases()]


@table(
    title="Coverage of intervals and rates of tests, simulated",
    columns=(
        Column("method", TEXT, "", "interval or test, and the situation", key=True),
        Column("truth", FLOAT, "1", "what the interval should hold; the level of a test", key=True),
        Column("n", INT, "1", "units in a data set", key=True),
        Column("repeats", INT, "1", "data sets"),
        Column(
            "coverage_or_rate", FLOAT, "1",
            "fraction of the data sets in which the interval holds the truth, or the test rejects",
            low=0, high=1,
        ),
        Column("low", FLOAT, "1", "lower end of its 95 % interval", low=0, high=1),
        Column("high", FLOAT, "1", "upper end", low=0, high=1),
        Column("holds", BOOL, "", "whether that interval meets the band that the method promises"),
    ),
    settings=lambda config: [(case.method, case.repeats, case.band) for case in cases()],
    expected=lambda config: Expected(
        ("method", "truth", "n"), {(c.method, c.truth, c.n): 1 for c in cases()}
    ),
)  # fmt: skip
def calibration(config: Config) -> Batched:
    """A row per simulation, each with a random stream of its own."""
    simulations = cases()

    def compute(start: int, stop: int) -> pd.DataFrame:
        rows = []
        for case in simulations[start:stop]:
            rng = generator(config.seed, "calibration", case.method, f"{case.truth:g}")
            rows.append((case.method, case.truth, case.n, *run_case(case, rng)))
        return pd.DataFrame(rows, columns=calibration.column_names)

    return Batched(compute, size=1, units=len(simulations))
