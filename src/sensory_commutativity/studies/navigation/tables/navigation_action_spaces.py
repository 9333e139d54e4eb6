"""The action spaces of all training runs, made from the measured SCPs (paper, section IV-B)."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....storage.tables import read_table, write_table
from ...config import Config
from ..builders import measured_scp, scales_of_run

TABLE = "navigation_action_spaces"


def write_action_spaces(navigation_scp: Path, out: Path, config: Config) -> None:
    """A row per run and degree of freedom."""
    scp = measured_scp(config, read_table("navigation_scp", navigation_scp))
    rows = [
        (action_space, seed, dof, scp[dof], scale)
        for action_space, seed in config.navigation.runs
        for dof, scale in scales_of_run(config, scp, action_space, seed).items()
    ]
    write_table(
        TABLE,
        pd.DataFrame(rows, columns=["action_space", "seed", "dof", "scp", "scale"]),
        out,
        config,
    )
