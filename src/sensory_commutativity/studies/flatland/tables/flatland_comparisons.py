"""Whether the SCP of one degree of freedom is below that of another: McNemar tests on shared start
situations, Holm-corrected."""

from __future__ import annotations

from itertools import combinations
from math import comb

import pandas as pd

from ....scp.estimate import commutes
from ....storage.columns import FLOAT, INT, INTERVAL, P_VALUES, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import DOFS
from ..columns import AGENT, DOF_A, DOF_B, WORLD


def compare_dofs(experiments: pd.DataFrame, threshold: float = 0.0) -> pd.DataFrame:
    """Compare all pairs of degrees of freedom of one agent in one world.

    Parameters
    ----------
    experiments : DataFrame
        Columns dof, experiment, distance; every degree of freedom must have the same experiments.
    threshold : float
        Largest distance that counts as equal.

    Returns
    -------
    DataFrame
        A row per pair: dof_a, dof_b, test, n, only_a, only_b, difference, ci_low, ci_high, p,
        p_adjusted (Holm over all pairs).
    """
    from ....statistics.paired import holm, mcnemar, paired_difference_interval

    by_dof = experiments.pivot(index="experiment", columns="dof", values="distance")
    if by_dof.isna().any().any():
        raise ValueError("a paired test needs the same experiments for every degree of freedom")
    rows = []
    for a, b in combinations(experiments["dof"].unique(), 2):
        commuted_a = commutes(by_dof[a].to_numpy(), threshold)
        commuted_b = commutes(by_dof[b].to_numpy(), threshold)
        test = mcnemar(commuted_a, commuted_b)
        low, high = paired_difference_interval(test.only_a, test.only_b, len(by_dof))
        rows.append(
            (a, b, "McNemar, exact", len(by_dof), test.only_a, test.only_b, test.difference,
             low, high, test.p)
        )  # fmt: skip
    columns = ["dof_a", "dof_b", "test", "n", "only_a", "only_b", "difference", "ci_low",
               "ci_high", "p"]  # fmt: skip
    comparisons = pd.DataFrame(rows, columns=columns)
    comparisons["p_adjusted"] = holm(comparisons["p"].to_numpy())
    return comparisons


def _expected(config: Config) -> Expected:
    flatland = config.flatland
    runs = [run for run in flatland.runs() if run.length == flatland.sequence_length]
    return Expected(("world", "agent"), {run[:2]: comb(len(DOFS), 2) for run in runs})


@table(
    title="Pairwise comparisons of the SCPs in Flatland",
    columns=(
        WORLD,
        AGENT,
        DOF_A,
        DOF_B,
        Column("test", TEXT, "", "name of the test"),
        Column("n", INT, "1", "start situations in which both were tried"),
        Column("only_a", INT, "1", "situations in which only a commuted"),
        Column("only_b", INT, "1", "situations in which only b commuted"),
        Column("difference", FLOAT, "1", "SCP of a minus SCP of b"),
        *INTERVAL,
        *P_VALUES,
    ),
    inputs=["flatland_experiments"],
    settings=lambda config: config.flatland.sequence_length,
    expected=_expected,
)
def flatland_comparisons(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """All pairs, for every agent in every world, at the main sequence length and threshold 0."""
    rows = experiments[experiments["length"] == config.flatland.sequence_length]
    comparisons = [
        compare_dofs(group).assign(world=world, agent=agent)
        for (world, agent), group in rows.groupby(["world", "agent"], sort=False)
    ]
    return pd.concat(comparisons, ignore_index=True)
