"""Tests: is the SCP of a degree of freedom below that of its control, and are relative SCPs of
different degrees of freedom in the order of the paper?"""

from __future__ import annotations

import math
from itertools import chain

import pandas as pd

from ....scp.estimate import commutes
from ....storage.columns import FLOAT, INT, P_VALUES, TEXT, Column
from ...config import Config
from ...declarations import table
from ...flatland.hierarchy import HIERARCHY
from ..columns import WORLD
from ..estimates import at_quiet_starts

COLUMNS = ["test", "lower", "higher", "n", "lower_value", "higher_value", "p"]
ORDER_EFFECT, STEP = "below its control", "step of the hierarchy"


def test_trials(trials: pd.DataFrame, threshold: float) -> pd.DataFrame:
    """The tests of one world.

    Parameters
    ----------
    trials : DataFrame
        Columns dof, experiment, distance, control, of one world.
    threshold : float

    Returns
    -------
    DataFrame
        Columns COLUMNS and p_adjusted (Holm, for each kind of test on its own).
    """
    from ....statistics.paired import holm, mcnemar
    from ....statistics.ratios import compare_ratios

    wide = trials.pivot(index="experiment", columns="dof", values=["distance", "control"])
    decided = {
        dof: (commutes(wide["distance", dof], threshold), commutes(wide["control", dof], threshold))
        for dof in trials["dof"].unique()
    }
    effects, steps = [], []
    for dof, (found, control) in decided.items():
        p = mcnemar(found, control).p
        effects.append((ORDER_EFFECT, dof, "control", len(found), found.mean(), control.mean(), p))
    for lower, higher in chain.from_iterable(HIERARCHY.values()):
        if lower in decided and higher in decided:
            a, b = decided[lower], decided[higher]
            values = [x.mean() / y.mean() if y.any() else math.nan for x, y in (a, b)]
            steps.append((STEP, lower, higher, len(a[0]), *values, compare_ratios(a, b).p))
    frames = []
    for rows in (effects, steps):
        frame = pd.DataFrame(rows, columns=COLUMNS)
        frame["p_adjusted"] = holm(frame["p"].to_numpy())
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


@table(
    title="Tests of the return protocol",
    columns=(
        WORLD,
        Column("starts", TEXT, "", "all, or quiet: nothing was seen to move beforehand", key=True),
        Column("test", TEXT, "", f"{ORDER_EFFECT} (McNemar), or {STEP} (ratios)", key=True),
        Column("lower", TEXT, "", "degree of freedom that should have the lower value", key=True),
        Column("higher", TEXT, "", "the other, or control", key=True),
        Column("n", INT, "1", "trials of each"),
        Column("lower_value", FLOAT, "1", "SCP, or SCP relative to the control", nullable=True),
        Column("higher_value", FLOAT, "1", "the same of the other", nullable=True),
        *P_VALUES,
    ),
    inputs=["reset_free_trials"],
)
def reset_free_comparisons(trials: pd.DataFrame, config: Config) -> pd.DataFrame:
    """All worlds of Flatland, at threshold 0."""
    return pd.concat(
        [
            test_trials(of_world, 0.0).assign(world=world, starts=starts)
            for starts, part in (("all", trials), ("quiet", at_quiet_starts(trials)))
            for world, of_world in part.groupby("world", sort=False)
        ],
        ignore_index=True,
    )
