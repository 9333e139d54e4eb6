"""Naive change and prediction error of every degree of freedom, and how far they agree with the SCP (paper, appendix A)."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from ....seeding import generator, seed_for
from ....statistics.ranks import rank_correlation
from ....storage.tables import read_table, write_table
from ...config import Config
from ..naive_change import mean_and_standard_error, squared_change
from ..transitions import collect_transitions

TABLE = "flatland_baselines"


def write_baseline(config: Config, dof: str, out: Path) -> None:
    """Measure both alternatives for one degree of freedom; its excess error is not known yet."""
    from ..prediction import (
        prediction_error,  # torch takes seconds to import, and only this command needs it
    )

    transitions = collect_transitions(config, dof)
    naive, naive_se = mean_and_standard_error(squared_change(transitions))
    errors = prediction_error(
        transitions, config.flatland.baselines, seed_for(config.seed, "prediction", dof) % 2**32
    )
    predicted, predicted_se = mean_and_standard_error(errors)
    n_test = errors.size * transitions.actions.shape[1]
    row = dict(
        dof=dof, naive_mse=naive, naive_se=naive_se, prediction_mse=predicted, prediction_se=predicted_se,
        excess_error=float("nan"), n_transitions=config.flatland.baselines.transitions, n_test=n_test,
    )  # fmt: skip
    write_table(TABLE, pd.DataFrame([row]), out, config)


def gather_baselines(parts: list[Path], out: Path, config: Config) -> None:
    """Put the degrees of freedom together; the excess error is what each has above the smallest error (paper, appendix A)."""
    frame = pd.concat([read_table(TABLE, part) for part in parts], ignore_index=True)
    frame["excess_error"] = frame["prediction_mse"] - frame["prediction_mse"].min()
    write_table(TABLE, frame, out, config)


def write_alternatives(baselines: Path, scp: Path, out: Path, config: Config) -> None:
    """Rank correlation of each alternative with 1 - SCP over the degrees of freedom: 1 if it put them in the same order as the SCP."""
    reference = config.flatland.reference
    rows = read_table("flatland_scp", scp)
    rows = rows[
        (rows["world"] == reference.world)
        & (rows["agent"] == reference.agent)
        & (rows["threshold"] == 0)
    ]
    frame = read_table(TABLE, baselines).merge(
        rows[["dof", "scp"]], on="dof", validate="one_to_one"
    )
    table = []
    for alternative, column in (
        ("naive change", "naive_mse"),
        ("excess prediction error", "excess_error"),
    ):
        rng = generator(seed_for(config.seed, "alternatives"), alternative)
        found = rank_correlation(frame[column].to_numpy(), 1 - frame["scp"].to_numpy(), rng)
        table.append((alternative, found.n, found.spearman, found.kendall, found.p))
    columns = ["alternative", "n", "spearman", "kendall", "p"]
    write_table("flatland_alternatives", pd.DataFrame(table, columns=columns), out, config)
