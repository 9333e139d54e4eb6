"""The SCP of the agent that learns, from which its action spaces are made (paper, section IV-B).

These are rows of flatland_scp, computed from the experiments of that agent alone: if settings of
another agent or world change, no run is trained again.
"""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import estimate_scp
from ...config import Config
from ...declarations import Expected, table
from ...flatland.builders import DOFS
from ...flatland.columns import SCP
from ...flatland.tables.flatland_scp import KEYS


def _inputs(config: Config, run: str | None) -> list[str]:
    navigation, length = config.navigation, config.flatland.sequence_length
    return [f"flatland_experiments/{navigation.scp_world}.{navigation.agent}.{length}"]


def _expected(config: Config) -> Expected:
    navigation, length = config.navigation, config.flatland.sequence_length
    rows = {(navigation.scp_world, navigation.agent, length): len(DOFS)}
    return Expected(("world", "agent", "length"), rows)


@table(
    title="SCP of the agent that learns to navigate",
    columns=SCP,
    inputs=_inputs,
    expected=_expected,
)
def navigation_scp(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The SCP at threshold 0."""
    return estimate_scp(experiments, KEYS, [0.0])
