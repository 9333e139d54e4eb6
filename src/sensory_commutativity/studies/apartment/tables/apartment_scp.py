"""The SCP of every degree of freedom of every robot (paper, Fig. "iGibson", right, and
appendix C)."""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import estimate_scp
from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import count_dofs
from ..columns import CONDITION, DOF, THRESHOLD, VIEW

KEYS = [column.name for column in (*CONDITION, VIEW)]
"""Columns that identify a condition: robot, apartment, start, length and field of view."""


def _expected(config: Config) -> Expected:
    settings, dofs = config.apartment, count_dofs(config.apartment)
    counts = {
        (*run[:4], view): dofs[run.robot] * len(settings.thresholds)
        for run in settings.runs()
        for view in settings.views(run)
    }
    return Expected(tuple(KEYS), counts)


@table(
    title="SCP of every degree of freedom in apartments",
    columns=(
        *CONDITION,
        VIEW,
        DOF,
        THRESHOLD,
        Column("n", INT, "1", "SC-experiments"),
        Column("commuted", INT, "1", "how many of them commuted"),
        Column("scp", FLOAT, "1", "sensory commutativity probability", low=0, high=1),
        *INTERVAL,
    ),
    inputs=["apartment_experiments"],
    settings=lambda config: config.apartment.thresholds,
    expected=_expected,
)
def apartment_scp(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The SCP at every threshold, for every condition and degree of freedom."""
    return estimate_scp(experiments, [*KEYS, "dof"], config.apartment.thresholds)
