"""The probability that two degrees of freedom commute (paper, section II-C)."""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import commutes
from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import DOFS
from ..columns import DOF_A, DOF_B, WORLD


def _expected(config: Config) -> Expected:
    worlds = config.flatland.commutation_worlds()
    return Expected(("world",), {(world,): len(DOFS) ** 2 for world in worlds})


@table(
    title="Probability that two degrees of freedom commute",
    columns=(
        WORLD,
        DOF_A,
        DOF_B,
        Column("n", INT, "1", "experiments"),
        Column("commuted", INT, "1", "how many of them commuted"),
        Column(
            "probability",
            FLOAT,
            "1",
            "probability that a then b and b then a end equal",
            low=0,
            high=1,
        ),
        *INTERVAL,
    ),
    inputs=["flatland_commutation_experiments"],
    expected=_expected,
)
def flatland_commutation(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """At threshold 0, a row for every world and ordered pair."""
    from ....statistics.proportions import wilson_interval

    commuted = experiments.assign(commuted=commutes(experiments["distance"].to_numpy()))
    groups = commuted.groupby(["world", "dof_a", "dof_b"], sort=False)["commuted"]
    pairs = groups.agg(n="size", commuted="sum").reset_index()
    mirrored = pairs[pairs["dof_a"] != pairs["dof_b"]]
    mirrored = mirrored.rename(columns={"dof_a": "dof_b", "dof_b": "dof_a"})
    pairs = pd.concat([pairs, mirrored], ignore_index=True)
    pairs["probability"] = pairs["commuted"] / pairs["n"]
    pairs["ci_low"], pairs["ci_high"] = wilson_interval(
        pairs["commuted"].to_numpy(), pairs["n"].to_numpy()
    )
    return pairs
