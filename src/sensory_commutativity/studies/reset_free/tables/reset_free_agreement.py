"""How often the return protocol decides an experiment as the experiment with a restored start
does."""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import commutes
from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import table
from ..columns import DOF, WORLD


def compare_decisions(trials: pd.DataFrame, threshold: float) -> pd.DataFrame:
    """A row per world and degree of freedom: world, dof, n, agreement, spearman.

    The rank correlation is that of the SCPs of all degrees of freedom of the world; NaN if all
    SCPs are equal.
    """
    from scipy.stats import spearmanr

    rows = []
    for world, of_world in trials.groupby("world", sort=False):
        decided = {
            dof: (
                commutes(of_dof["reset"].to_numpy(), threshold),
                commutes(of_dof["distance"].to_numpy(), threshold),
            )
            for dof, of_dof in of_world.groupby("dof", sort=False)
        }
        truth = [true.mean() for true, _ in decided.values()]
        found = [other.mean() for _, other in decided.values()]
        constant = len(set(truth)) == 1 or len(set(found)) == 1
        spearman = float("nan") if constant else float(spearmanr(truth, found).statistic)
        for dof, (true, other) in decided.items():
            rows.append((world, dof, len(true), float((true == other).mean()), spearman))
    return pd.DataFrame(rows, columns=["world", "dof", "n", "agreement", "spearman"])


@table(
    title="Agreement of the return protocol with the truth",
    columns=(
        WORLD,
        DOF,
        Column("n", INT, "1", "trials"),
        Column("agreement", FLOAT, "1", "share of trials that both protocols decide alike"),
        Column(
            "spearman", FLOAT, "1",
            "rank correlation of the SCPs by both protocols, over all degrees of freedom",
            nullable=True,
        ),
    ),
    inputs=["reset_free_trials", "reset_free_apartment"],
    settings=lambda config: config.apartment.reference.threshold,
)  # fmt: skip
def reset_free_agreement(
    trials: pd.DataFrame, apartment: pd.DataFrame, config: Config
) -> pd.DataFrame:
    """At threshold 0 in Flatland, at that of the reference in apartments."""
    parts = [compare_decisions(trials, 0.0)]
    if len(apartment):
        parts.append(compare_decisions(apartment, config.apartment.reference.threshold))
    return pd.concat(parts, ignore_index=True)
