"""The SCP against sequence length and threshold, in the reference world."""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import estimate_scp
from ...config import Config
from ...declarations import Expected, table
from ..builders import DOFS
from ..columns import SCP
from .flatland_scp import KEYS


def _expected(config: Config) -> Expected:
    flatland = config.flatland
    lengths = [flatland.sequence_length, *flatland.sensitivity.lengths]
    rows = len(DOFS) * len(flatland.thresholds)
    return Expected(("length",), {(length,): rows for length in lengths})


@table(
    title="SCP against sequence length and threshold",
    columns=SCP,
    inputs=["flatland_experiments"],
    settings=lambda config: [
        config.flatland.thresholds, config.flatland.sensitivity, config.flatland.reference,
    ],
    expected=_expected,
)  # fmt: skip
def flatland_sensitivity(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """The SCP of all sequence lengths in the reference world, at every threshold.

    The main length is estimated from as many experiments as the others, so that all lengths share
    their start situations.
    """
    flatland, n = config.flatland, config.flatland.sensitivity.experiments
    reference = flatland.reference
    rows = experiments[
        (experiments["world"] == reference.world)
        & (experiments["agent"] == reference.agent)
        & (experiments["experiment"] < n)
    ].sort_values(["length", "experiment"], kind="stable")
    return estimate_scp(rows, KEYS, flatland.thresholds)
