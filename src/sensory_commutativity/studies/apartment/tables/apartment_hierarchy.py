"""Are wheels below the arm, and does the arm rise outward? Groups of degrees of freedom compared on shared start situations (section III-C).

The groups and their expected order are those of the robot's description. In every start situation the mean of a group is the fraction of its degrees
of freedom that commuted; the paired differences of two groups are tested (Student's t), Holm-corrected over the steps of a condition.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

from ....scp.estimate import commutes
from ....statistics.paired import holm
from ....storage.tables import TABLES, read_table, write_table
from ....worlds.apartment.robots.robot import load_robot
from ...config import Config
from .apartment_scp import CONDITION


def group_steps(
    experiments: pd.DataFrame, groups: dict[str, list[str]], threshold: float
) -> pd.DataFrame:
    """Every pair of neighbouring groups, (lower, higher) as expected.

    Parameters
    ----------
    experiments : DataFrame
        Columns dof, experiment, distance of one condition.
    groups : mapping
        Group -> its degrees of freedom, from the lowest expected SCP to the highest.

    Returns
    -------
    DataFrame
        lower, higher, n, scp_lower, scp_higher, difference (lower minus higher), ci_low, ci_high, p, p_adjusted.
    """
    commuted = experiments.assign(commuted=commutes(experiments["distance"].to_numpy(), threshold))
    by_dof = commuted.pivot(index="experiment", columns="dof", values="commuted").astype(float)
    means = {group: by_dof[dofs].mean(axis=1).to_numpy() for group, dofs in groups.items()}
    rows = []
    names = list(groups)
    for lower, higher in pairwise(names):
        difference = means[lower] - means[higher]
        test = paired_means(difference)
        rows.append(
            (
                lower,
                higher,
                len(difference),
                means[lower].mean(),
                means[higher].mean(),
                difference.mean(),
                *test,
            )
        )
    columns = [
        "lower",
        "higher",
        "n",
        "scp_lower",
        "scp_higher",
        "difference",
        "ci_low",
        "ci_high",
        "p",
    ]
    table = pd.DataFrame(rows, columns=columns)
    table["p_adjusted"] = holm(table["p"].to_numpy())
    return table


def paired_means(difference: np.ndarray, confidence: float = 0.95) -> tuple[float, float, float]:
    """Interval of the mean of paired differences (n,), and the two-sided p-value of its being 0: (low, high, p).

    Student's t; where all differences are equal, and not 0, the exact sign test, and as the interval what is left when as many of them have the other
    sign as the Clopper-Pearson interval of none in n allows.
    """
    mean, n = float(difference.mean()), len(difference)
    if (
        np.ptp(difference) == 0
    ):  # no variance to test with: the exact sign test, and an interval that no further value of another sign would leave
        if mean == 0:
            return 0.0, 0.0, 1.0
        ends = sorted((mean, mean * (1 - 2 * (1 - ((1 - confidence) / 2) ** (1 / n)))))
        return ends[0], ends[1], min(1.0, 2.0 ** (1 - n))
    low, high = stats.t.interval(confidence, len(difference) - 1, mean, stats.sem(difference))
    return float(low), float(high), float(stats.ttest_1samp(difference, 0).pvalue)


def write_hierarchy(experiments: Path, out: Path, config: Config) -> None:
    """All conditions at all thresholds."""
    frame = read_table("apartment_experiments", experiments)
    descriptions = {
        name: load_robot(robot.description) for name, robot in config.apartment.robots.items()
    }
    tables = []
    for condition, rows in frame.groupby(CONDITION, sort=False):
        groups = descriptions[condition[0]].hierarchy
        for threshold in config.apartment.thresholds if len(groups) > 1 else ():
            tables.append(
                group_steps(rows, groups, threshold).assign(
                    threshold=threshold, **dict(zip(CONDITION, condition, strict=True))
                )
            )
    frame = (
        pd.concat(tables, ignore_index=True)
        if tables
        else pd.DataFrame(columns=[column.name for column in TABLES["apartment_hierarchy"]])
    )
    write_table("apartment_hierarchy", frame, out, config)
