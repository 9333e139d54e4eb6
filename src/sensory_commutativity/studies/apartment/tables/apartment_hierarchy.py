"""Whether the SCP of the wheels is below that of the arm, and rises along the arm (paper, section
III-C): groups of degrees of freedom compared on shared start situations.

The groups and their expected order are part of the robot's description. The mean of a group in a
start situation is the fraction of its degrees of freedom that commuted. Differences between two
groups are tested by a paired t-test, Holm-corrected over the steps of a condition.
"""

from __future__ import annotations

from itertools import pairwise

import pandas as pd

from ....scp.estimate import commutes
from ....storage.columns import FLOAT, INT, INTERVAL, P_VALUES, TEXT, Column
from ...config import Config
from ...declarations import Expected, table
from ..builders import contents, load_named_robot
from ..columns import CONDITION, THRESHOLD, VIEW
from .apartment_scp import KEYS


def compare_groups(
    experiments: pd.DataFrame, groups: dict[str, list[str]], threshold: float
) -> pd.DataFrame:
    """Compare every group with the next.

    Parameters
    ----------
    experiments : DataFrame
        Columns dof, experiment, distance of one condition.
    groups : dict
        Group -> its degrees of freedom, from the lowest expected SCP to the highest.
    threshold : float
        Largest distance that counts as equal.

    Returns
    -------
    DataFrame
        A row per step from one group to the next: lower, higher, n, scp_lower, scp_higher,
        difference (lower minus higher), ci_low, ci_high, p, p_adjusted.
    """
    from ....statistics.paired import holm, paired_means

    commuted = experiments.assign(commuted=commutes(experiments["distance"].to_numpy(), threshold))
    by_dof = commuted.pivot(index="experiment", columns="dof", values="commuted").astype(float)
    means = {group: by_dof[dofs].mean(axis=1).to_numpy() for group, dofs in groups.items()}
    rows = []
    for lower, higher in pairwise(groups):
        difference = means[lower] - means[higher]  # (experiments,)
        rows.append(
            (lower, higher, len(difference), means[lower].mean(), means[higher].mean(),
             difference.mean(), *paired_means(difference))
        )  # fmt: skip
    columns = ["lower", "higher", "n", "scp_lower", "scp_higher", "difference", "ci_low",
               "ci_high", "p"]  # fmt: skip
    steps = pd.DataFrame(rows, columns=columns)
    steps["p_adjusted"] = holm(steps["p"].to_numpy())
    return steps


def _settings(config: Config) -> object:
    robots = config.apartment.robots
    return [
        config.apartment.thresholds,
        {name: contents(robot.description, "robot") for name, robot in robots.items()},
    ]


def _expected(config: Config) -> Expected:
    settings = config.apartment
    robots = dict.fromkeys(run.robot for run in settings.runs())
    groups = {robot: len(load_named_robot(settings, robot).hierarchy) for robot in robots}
    counts = {
        (*run[:4], view): (groups[run.robot] - 1) * len(settings.thresholds)
        for run in settings.runs()
        if groups[run.robot] > 1
        for view in settings.views(run)
    }
    return Expected(tuple(KEYS), counts)


@table(
    title="SCP along the hierarchy of every robot",
    columns=(
        *CONDITION,
        VIEW,
        THRESHOLD,
        Column("lower", TEXT, "", "group of dofs that is expected to have the lower SCP", key=True),
        Column("higher", TEXT, "", "the next group, expected to have a higher SCP", key=True),
        Column("n", INT, "1", "start situations"),
        Column("scp_lower", FLOAT, "1", "mean SCP of the group lower", low=0, high=1),
        Column("scp_higher", FLOAT, "1", "mean SCP of the group higher", low=0, high=1),
        Column("difference", FLOAT, "1", "scp_lower minus scp_higher"),
        *INTERVAL,
        *P_VALUES,
    ),
    inputs=["apartment_experiments"],
    settings=_settings,
    expected=_expected,
)
def apartment_hierarchy(experiments: pd.DataFrame, config: Config) -> pd.DataFrame:
    """All steps of all conditions, at every threshold; no rows for a robot without a hierarchy."""
    robots = experiments["robot"].unique()
    hierarchies = {robot: load_named_robot(config.apartment, robot).hierarchy for robot in robots}
    tables = [
        compare_groups(rows, hierarchies[condition[0]], threshold).assign(
            threshold=threshold, **dict(zip(KEYS, condition, strict=True))
        )
        for condition, rows in experiments.groupby(KEYS, sort=False)
        if len(hierarchies[condition[0]]) > 1
        for threshold in config.apartment.thresholds
    ]
    if not tables:
        return pd.DataFrame(columns=apartment_hierarchy.column_names)
    return pd.concat(tables, ignore_index=True)
