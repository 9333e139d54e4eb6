"""The SCP of the agent that learns: what its action spaces are made from (paper, section IV-B).

These are rows of flatland_scp, made from that agent's experiments alone, so that no setting of another agent or world trains all runs anew.
"""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....scp.estimate import estimate_scp
from ....storage.tables import read_table, write_table
from ...config import Config
from ...flatland.tables.flatland_scp import KEYS


def write_navigation_scp(parts: list[Path], out: Path, config: Config) -> None:
    """The SCP at threshold 0 from the parts of flatland_experiments of the run that the action spaces are made from."""
    frame = pd.concat(
        [read_table("flatland_experiments", part) for part in parts], ignore_index=True
    )
    write_table("navigation_scp", estimate_scp(frame, KEYS, [0.0]), out, config)
