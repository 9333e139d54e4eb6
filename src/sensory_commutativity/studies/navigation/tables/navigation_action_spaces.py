"""The action spaces of all training runs, made from the measured SCPs (paper, section IV-B)."""

from __future__ import annotations

import pandas as pd

from ....storage.columns import FLOAT, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ...flatland.builders import DOFS
from ..builders import measured_scp, scales_of_run
from ..columns import RUN


def _settings(config: Config) -> object:
    navigation = config.navigation
    return [navigation.scp_world, navigation.agent, navigation.action_spaces, navigation.seeds,
            config.flatland.sequence_length]  # fmt: skip


@table(
    title="Action spaces of all training runs",
    columns=(
        *RUN,
        Column("dof", TEXT, "", "degree of freedom", key=True),
        Column("scp", FLOAT, "1", "its measured sensory commutativity probability", low=0, high=1),
        Column("scale", FLOAT, "1", "factor of its action interval; 0 removes it"),
    ),
    inputs=["navigation_scp"],
    settings=_settings,
    expected=lambda config: Expected(
        ("action_space", "seed"), dict.fromkeys(config.navigation.runs, len(DOFS))
    ),
)
def navigation_action_spaces(scp_table: pd.DataFrame, config: Config) -> pd.DataFrame:
    """A row per run and degree of freedom."""
    scp = measured_scp(config, scp_table)
    rows = [
        (action_space, seed, dof, scp[dof], scale)
        for action_space, seed in config.navigation.runs
        for dof, scale in scales_of_run(config, scp, action_space, seed).items()
    ]
    return pd.DataFrame(rows, columns=navigation_action_spaces.column_names)
