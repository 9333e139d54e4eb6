"""The SCP of every degree of freedom of every robot, at all thresholds and fields of view (paper, Fig. "iGibson", right, and appendix C)."""

from __future__ import annotations

from pathlib import Path

from ....scp.estimate import estimate_scp
from ....storage.tables import read_table, write_table
from ...config import Config

CONDITION = ["robot", "apartment", "start", "length", "field_of_view"]


def write_scp(experiments: Path, out: Path, config: Config) -> None:
    """A row per condition, degree of freedom and threshold."""
    frame = read_table("apartment_experiments", experiments)
    write_table(
        "apartment_scp",
        estimate_scp(frame, [*CONDITION, "dof"], config.apartment.thresholds),
        out,
        config,
    )
