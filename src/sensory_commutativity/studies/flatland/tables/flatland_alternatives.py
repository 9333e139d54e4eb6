"""How far the alternatives order the degrees of freedom as the SCP does (paper, appendix A)."""

from __future__ import annotations

import pandas as pd

from ....seeding import generator, seed_for
from ....storage.columns import FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Expected, table

ALTERNATIVES = {"naive change": "naive_mse", "excess prediction error": "excess_error"}
"""Name -> column of the table flatland_baselines."""


@table(
    title="Rank correlation of the alternatives with the SCP",
    columns=(
        Column("alternative", TEXT, "", "naive change or excess prediction error", key=True),
        Column("n", INT, "1", "degrees of freedom"),
        Column(
            "spearman", FLOAT, "1", "Spearman's rank correlation with 1 - SCP; 1 is the same order",
            nullable=True,
        ),
        Column("kendall", FLOAT, "1", "Kendall's tau-b with 1 - SCP", nullable=True),
        Column(
            "p", FLOAT, "1", "two-sided p-value of Spearman's coefficient, permutation test",
            low=0, high=1,
        ),
    ),
    inputs=["flatland_baselines", "flatland_scp"],
    settings=lambda config: config.flatland.reference,
    expected=lambda config: Expected(("alternative",), {(name,): 1 for name in ALTERNATIVES}),
)  # fmt: skip
def flatland_alternatives(
    baselines: pd.DataFrame, scp: pd.DataFrame, config: Config
) -> pd.DataFrame:
    """Rank correlation of each alternative with 1 - SCP over the degrees of freedom."""
    from ....statistics.ranks import rank_correlation

    reference = config.flatland.reference
    scp = scp[
        (scp["world"] == reference.world)
        & (scp["agent"] == reference.agent)
        & (scp["threshold"] == 0)
    ]
    merged = baselines.merge(scp[["dof", "scp"]], on="dof", validate="one_to_one")
    rows = []
    for alternative, column in ALTERNATIVES.items():
        rng = generator(seed_for(config.seed, "alternatives"), alternative)
        change = 1 - merged["scp"].to_numpy()
        correlation = rank_correlation(merged[column].to_numpy(), change, rng)
        rows.append((alternative, correlation.n, correlation.spearman, correlation.kendall,
                     correlation.p))  # fmt: skip
    return pd.DataFrame(rows, columns=["alternative", "n", "spearman", "kendall", "p"])
