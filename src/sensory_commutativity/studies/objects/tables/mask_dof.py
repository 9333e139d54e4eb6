"""Which degree of freedom plays the SC-experiments on objects: that whose SCP is nearest one half (paper, section IV-A)."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....storage.tables import read_table, write_table
from ...config import Config
from ..builders import dof_nearest_half


def write_dof(apartment_scp: Path, out: Path, config: Config) -> None:
    """One row: the robot, the degree of freedom, its SCP."""
    dof, scp = dof_nearest_half(read_table("apartment_scp", apartment_scp), config)
    write_table(
        "mask_dof",
        pd.DataFrame([(config.masks.robot, dof, scp)], columns=["robot", "dof", "scp"]),
        out,
        config,
    )


def read_dof(mask_dof: Path, config: Config) -> int:
    """Place of that degree of freedom in the robot's action vector."""
    from ..builders import robot_of_masks

    dof = read_table("mask_dof", mask_dof)["dof"].iloc[0]
    return [one.name for one in robot_of_masks(config).dofs].index(dof)
