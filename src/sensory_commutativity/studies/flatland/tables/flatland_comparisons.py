"""Is the SCP of one degree of freedom below that of another? McNemar tests on shared start situations, Holm-corrected."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import pandas as pd

from ....scp.estimate import commutes
from ....statistics.paired import holm, mcnemar, paired_difference_interval
from ....storage.tables import read_table, write_table
from ...config import Config


def compare_dofs(experiments: pd.DataFrame, threshold: float = 0.0) -> pd.DataFrame:
    """All pairs of degrees of freedom of one agent in one world; p-values corrected for that family of tests.

    Parameters
    ----------
    experiments : DataFrame
        Columns dof, experiment, distance; every degree of freedom must have the same experiments.

    Returns
    -------
    DataFrame
        A row per pair: dof_a, dof_b, test, n, only_a, only_b, difference, ci_low, ci_high, p, p_adjusted.
    """
    by_dof = experiments.pivot(index="experiment", columns="dof", values="distance")
    if by_dof.isna().any().any():
        raise ValueError("a paired test needs the same experiments for every degree of freedom")
    rows = []
    for a, b in combinations(experiments["dof"].unique(), 2):
        test = mcnemar(
            commutes(by_dof[a].to_numpy(), threshold), commutes(by_dof[b].to_numpy(), threshold)
        )
        low, high = paired_difference_interval(test.only_a, test.only_b, len(by_dof))
        rows.append(
            (
                a,
                b,
                "McNemar, exact",
                len(by_dof),
                test.only_a,
                test.only_b,
                test.difference,
                low,
                high,
                test.p,
            )
        )
    table = pd.DataFrame(
        rows,
        columns=[
            "dof_a",
            "dof_b",
            "test",
            "n",
            "only_a",
            "only_b",
            "difference",
            "ci_low",
            "ci_high",
            "p",
        ],
    )
    table["p_adjusted"] = holm(table["p"].to_numpy())
    return table


def write_comparisons(experiments: Path, out: Path, config: Config) -> None:
    """All pairs, for every agent in every world, at the main sequence length and threshold 0."""
    frame = read_table("flatland_experiments", experiments)
    frame = frame[frame["length"] == config.flatland.sequence_length]
    tables = []
    for (world, agent), group in frame.groupby(["world", "agent"], sort=False):
        tables.append(compare_dofs(group).assign(world=world, agent=agent))
    write_table("flatland_comparisons", pd.concat(tables, ignore_index=True), out, config)
