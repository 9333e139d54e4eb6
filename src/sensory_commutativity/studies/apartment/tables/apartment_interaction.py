"""How often each degree of freedom touched something, according to the simulator, beside its SCP.
The robot's sensors do not show this."""

from __future__ import annotations

import pandas as pd

from ....scp.estimate import commutes
from ....storage.columns import FLOAT, INT, INTERVAL, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import count_dofs
from ..columns import CONDITION, DOF

MOVED = 0.01
"""Displacement from which an object counts as moved, metres. Chosen: a few pixels at the length of
an arm."""
KEYS = [column.name for column in (*CONDITION, DOF)]


def count_interactions(experiments: pd.DataFrame, threshold: float) -> pd.DataFrame:
    """Count touches and commuted experiments of every condition and degree of freedom.

    Parameters
    ----------
    experiments : DataFrame
        Rows of the table apartment_experiments, of one field of view.
    threshold : float
        Largest distance that counts as equal.

    Returns
    -------
    DataFrame
        Columns of the table apartment_interaction.
    """
    from ....statistics.proportions import wilson_interval

    rows = []
    for group, trials in experiments.groupby(KEYS, sort=False):
        commuted = commutes(trials["distance"].to_numpy(), threshold)
        touched = ((trials["touched_fixed"] > 0) | (trials["touched_movable"] > 0)).to_numpy()
        hindered = ((trials["touched_self"] > 0) | (trials["at_limit"] > 0)).to_numpy() & ~touched
        free = ~touched & ~hindered
        row = dict(zip(KEYS, group, strict=True), n=len(trials), scp=commuted.mean())
        row |= dict(
            touched=touched.mean(),
            touched_fixed=(trials["touched_fixed"] > 0).mean(),
            touched_movable=(trials["touched_movable"] > 0).mean(),
            moved_object=(trials["object_shift"] > MOVED).mean(),
            hindered=hindered.mean(),
        )
        for kind, mask in (("touched", touched), ("hindered", hindered), ("free", free)):
            row[f"n_{kind}"] = int(mask.sum())
            row[f"commuted_{kind}"] = int(commuted[mask].sum())
        rows.append(row)
    counts = pd.DataFrame(rows)
    counts["ci_low"], counts["ci_high"] = wilson_interval(
        counts["n_touched"].to_numpy(), counts["n"].to_numpy()
    )
    return counts


def _expected(config: Config) -> Expected:
    dofs = count_dofs(config.apartment)
    counts = {run[:4]: dofs[run.robot] for run in config.apartment.runs()}
    return Expected(("robot", "apartment", "start", "length"), counts)


@table(
    title="Touch and SCP of every degree of freedom in apartments",
    columns=(
        *CONDITION,
        DOF,
        Column("n", INT, "1", "SC-experiments"),
        Column(
            "scp", FLOAT, "1", "sensory commutativity probability at the reference threshold",
            low=0, high=1,
        ),
        Column("touched", FLOAT, "1", "fraction in which a fixture or an object was touched"),
        *INTERVAL,
        Column("touched_fixed", FLOAT, "1", "fraction in which a fixture was touched"),
        Column("touched_movable", FLOAT, "1", "fraction in which a movable object was touched"),
        Column(
            "moved_object", FLOAT, "1",
            "fraction in which an object was displaced by more than a centimetre", low=0, high=1,
        ),
        Column(
            "hindered", FLOAT, "1",
            "fraction in which only the robot's own body or a joint limit obstructed the motion",
        ),
        Column("n_touched", INT, "1", "experiments with touch"),
        Column("commuted_touched", INT, "1", "how many of them commuted"),
        Column("n_hindered", INT, "1", "experiments hindered by the robot itself"),
        Column("commuted_hindered", INT, "1", "how many of them commuted"),
        Column("n_free", INT, "1", "all others"),
        Column("commuted_free", INT, "1", "how many of them commuted"),
    ),
    inputs=["apartment_experiments"],
    settings=lambda config: [
        config.apartment.reference.threshold, config.apartment.fields_of_view[0],
    ],
    expected=_expected,
)  # fmt: skip
def apartment_interaction(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """At the reference threshold and the main field of view."""
    settings = config.apartment
    rows = experiments[experiments["field_of_view"] == settings.fields_of_view[0]]
    return count_interactions(rows, settings.reference.threshold)
