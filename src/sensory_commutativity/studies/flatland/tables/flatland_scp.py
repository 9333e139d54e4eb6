"""The SCP of every degree of freedom (paper, Fig. "SCP per DOF" and appendix B)."""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import estimate_scp
from ...config import Config
from ...declarations import Expected, table
from ..builders import DOFS
from ..columns import SCP

KEYS = ["world", "agent", "length", "dof"]


def _expected(config: Config) -> tuple[Expected, ...]:
    flatland = config.flatland
    rows = len(DOFS) * len(flatland.thresholds)
    runs = [run for run in flatland.runs() if run.length == flatland.sequence_length]
    keys = {
        (*run[:3], dof, threshold): 1
        for run in runs
        for dof in DOFS
        for threshold in flatland.thresholds
    }
    return (
        Expected(("world", "agent"), {run[:2]: rows for run in runs}),
        Expected((*KEYS, "threshold"), keys),
    )


@table(
    title="SCP of every degree of freedom in Flatland",
    columns=SCP,
    inputs=["flatland_experiments"],
    settings=lambda config: [config.flatland.thresholds, config.flatland.sequence_length],
    expected=_expected,
)
def flatland_scp(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The SCP at the main sequence length, at every threshold, for every agent in every world."""
    flatland = config.flatland
    rows = experiments[experiments["length"] == flatland.sequence_length]
    return estimate_scp(rows, KEYS, flatland.thresholds)
