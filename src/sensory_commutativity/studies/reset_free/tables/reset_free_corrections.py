"""What corrections of the return give where a push has moved the base."""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import commutes
from ....storage.columns import FLOAT, INT, INTERVAL, TEXT, Column
from ...config import Config
from ...declarations import table
from ..columns import DOF, WORLD

CORRECTIONS = {"none": "distance", "odometry": "odometry", "loop closure": "loop_closure"}
"""Correction -> column of its distances."""


@table(
    title="Corrections of the return in apartments",
    columns=(
        WORLD,
        DOF,
        Column("correction", TEXT, "", "none, odometry or loop closure", key=True),
        Column("n", INT, "1", "trials"),
        Column("moved", INT, "1", "trials whose first return did not lead the base back"),
        Column("scp", FLOAT, "1", "share of trials whose views are equal"),
        *INTERVAL,
        Column("true_scp", FLOAT, "1", "SCP with a restored start"),
        Column(
            "agreement", FLOAT, "1", "share of trials that are decided as with a restored start"
        ),
        Column(
            "moved_agreement", FLOAT, "1", "the same, of the trials whose base moved", nullable=True
        ),
    ),
    inputs=["reset_free_apartment"],
    settings=lambda config: config.apartment.reference.threshold,
)
def reset_free_corrections(trials: pd.DataFrame, config: Config) -> pd.DataFrame:
    """Of every degree of freedom, at the threshold of the apartment's reference."""
    from ....statistics.proportions import wilson_interval
    from .reset_free_apartment import BACK

    threshold, rows = config.apartment.reference.threshold, []
    for (world, dof), group in trials.groupby(["world", "dof"], sort=False):
        true = commutes(group["reset"].to_numpy(), threshold)
        moved = (group[["base_offset", "turn_offset"]].max(axis=1) > BACK).to_numpy()
        for correction, column in CORRECTIONS.items():
            found = commutes(group[column].to_numpy(), threshold)
            low, high = wilson_interval(int(found.sum()), len(found))
            alike = found == true
            of_moved = float(alike[moved].mean()) if moved.any() else float("nan")
            rows.append(
                (world, dof, correction, len(found), int(moved.sum()), found.mean(), float(low),
                 float(high), true.mean(), float(alike.mean()), of_moved)
            )  # fmt: skip
    return pd.DataFrame(rows, columns=reset_free_corrections.column_names)
