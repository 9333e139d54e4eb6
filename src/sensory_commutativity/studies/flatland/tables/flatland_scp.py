"""The SCP of every degree of freedom, for the main sequence length and for the others (paper, Fig. "SCP per DOF" and appendix B)."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....scp.estimate import estimate_scp
from ....storage.tables import read_table, write_table
from ...config import Config

KEYS = ["world", "agent", "length", "dof"]


def gather_experiments(parts: list[Path], out: Path, config: Config) -> None:
    """Put the parts of flatland_experiments together, in the order given."""
    frame = pd.concat(
        [read_table("flatland_experiments", part) for part in parts], ignore_index=True
    )
    write_table("flatland_experiments", frame, out, config)


def write_scp(experiments: Path, out: Path, config: Config) -> None:
    """The SCP of sequences of the main length, at every threshold, for every agent in every world."""
    frame = read_table("flatland_experiments", experiments)
    write_table(
        "flatland_scp",
        _scp(frame[frame["length"] == config.flatland.sequence_length], config),
        out,
        config,
    )


def write_sensitivity(experiments: Path, out: Path, config: Config) -> None:
    """The SCP of all sequence lengths in the reference world, at every threshold.

    The main length is taken from as many experiments as the others have, so that all lengths share their start situations.
    """
    frame = read_table("flatland_experiments", experiments)
    reference, n = config.flatland.reference, config.flatland.sensitivity.experiments
    chosen = frame[
        (frame["world"] == reference.world)
        & (frame["agent"] == reference.agent)
        & (frame["experiment"] < n)
    ]
    chosen = chosen.sort_values(["length", "experiment"], kind="stable")
    write_table("flatland_sensitivity", _scp(chosen, config), out, config)


def _scp(frame: pd.DataFrame, config: Config) -> pd.DataFrame:
    return estimate_scp(frame, KEYS, config.flatland.thresholds)
