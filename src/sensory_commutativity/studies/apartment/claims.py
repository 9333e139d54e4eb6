"""The paper's claims about robots in apartments (section III-C, appendix C), each decided by a rule that was fixed before the run.

The paper names thresholds from 20 to 100; a claim holds if it holds at every threshold of the configuration in that range.

- "lowest": the SCP of every wheel is below that of every other degree of freedom;
- "rising": every step from one group to the next of the robot's hierarchy has the right sign and a Holm-adjusted p-value below ALPHA;
- "always commutes": the SCP is at least ALMOST at threshold 100, since at lower ones a hair's breadth of motion counts;
- "the same hierarchy": Kendall's tau with the reference is at least SAME at every threshold, and defined there.

Two things that the paper implies are decided as well: in free space every degree of freedom commutes, at the lowest of these thresholds, in at
least FREE of the experiments; and the SCP of the arm joint nearest the body is nearer .5 than 0 or 1, so that its experiments have all outcomes.
"""

from __future__ import annotations

import pandas as pd

from ...worlds.apartment.robots.robot import load_robot
from ..claims import Claim, p_of_claim
from ..config import Config

ALPHA = 0.01
ALMOST = 0.95
SAME = 0.8
FREE = 0.99
RANGE = (20.0, 100.0)


def apartment_claims(tables: dict[str, pd.DataFrame], config: Config) -> list[Claim]:
    """All claims, from the tables apartment_scp, apartment_hierarchy and apartment_order."""
    settings = config.apartment
    reference = settings.reference
    claims = [
        *_of_robot(reference.robot, reference.scene, "III-C", tables, config),
        _still("torso-lift", reference.robot, reference.scene, tables["apartment_scp"], config),
        _nearest_half(reference.robot, reference.scene, tables["apartment_scp"], config),
        _same_for_all_thresholds(tables["apartment_order"]),
    ]
    claims += [
        _free(robot, scene, tables["apartment_scp"], config)
        for robot in settings.free_space.robots
        for scene in settings.free_space.scenes
    ]
    for robot in settings.robots_compared.robots:
        for scene in settings.robots_compared.scenes:
            claims += _of_robot(robot, scene, "App. C", tables, config)
    return [claim for claim in claims if claim is not None]


def _rows(table: pd.DataFrame, robot: str, scene: str, config: Config) -> pd.DataFrame:
    """Of a robot in an apartment, at the thresholds in the paper's range."""
    settings = config.apartment
    chosen = (
        (table["robot"] == robot) & (table["apartment"] == scene) & (table["start"] == "anywhere")
    )
    chosen &= (table["length"] == settings.sequence_length) & (
        table["field_of_view"] == settings.fields_of_view[0]
    )
    return table[chosen & table["threshold"].between(*RANGE)]


def _of_robot(
    robot: str, scene: str, section: str, tables: dict[str, pd.DataFrame], config: Config
) -> list[Claim]:
    described = load_robot(config.apartment.robots[robot].description)
    groups = described.hierarchy
    wheels = [
        dof.name for dof in described.description.dofs if set(dof.joints) & set(described.wheels)
    ]
    scps, steps = (
        _rows(tables[name], robot, scene, config)
        for name in ("apartment_scp", "apartment_hierarchy")
    )
    if scps.empty:
        return []
    return [
        *(_wheels_lowest(robot, section, wheels, scps) if wheels else []),
        *(_rising(robot, section, groups, steps) if len(groups) > 1 else []),
    ]


def _wheels_lowest(robot: str, section: str, wheels: list[str], scps: pd.DataFrame) -> list[Claim]:
    gaps = []
    for threshold, rows in scps.groupby("threshold"):
        scp = rows.set_index("dof")["scp"]
        gaps.append(
            (
                scp.drop(wheels).min() - scp[wheels].max(),
                threshold,
                scp[wheels].idxmax(),
                scp.drop(wheels).idxmin(),
            )
        )
    gap, threshold, *pair = min(gaps)
    (wheel, other) = (
        _with_interval(scps[(scps["threshold"] == threshold) & (scps["dof"] == dof)].iloc[0])
        for dof in pair
    )
    said = f"highest wheel {wheel}, next {pair[1]} {other} (threshold {threshold:g}, where it is closest)"
    return [
        Claim(
            f"{robot}: the wheels have the lowest SCP",
            section,
            "wheels lowest",
            said,
            None,
            None,
            bool(gap > 0),
        )
    ]


def _rising(
    robot: str, section: str, groups: dict[str, list[str]], steps: pd.DataFrame
) -> list[Claim]:
    worst = steps.loc[steps["p_adjusted"].idxmax()]
    rising = bool(((steps["difference"] < 0) & (steps["p_adjusted"] < ALPHA)).all())
    smallest = steps.loc[steps["difference"].idxmax()]
    order = " < ".join(groups)
    least = f"{smallest['difference']:+.3f} [{smallest['ci_low']:+.3f}, {smallest['ci_high']:+.3f}]"
    told = f"smallest step {smallest['lower']} - {smallest['higher']} {least}, largest {p_of_claim(worst['p_adjusted'])}"
    return [
        Claim(
            f"{robot}: the SCP rises along {order}",
            section,
            "rising outward",
            told,
            None,
            None,
            rising,
        )
    ]


def _with_interval(row: pd.Series) -> str:
    return f"{row['scp']:.2f} [{row['ci_low']:.2f}, {row['ci_high']:.2f}]"


def _still(dof: str, robot: str, scene: str, scp: pd.DataFrame, config: Config) -> Claim | None:
    rows = _rows(scp, robot, scene, config)
    rows = rows[rows["dof"] == dof]
    if rows.empty:
        return None
    last = rows.loc[rows["threshold"].idxmax()]
    said = (
        f"{int(last['commuted'])} of {int(last['n'])} commuted at threshold {last['threshold']:g}"
    )
    return Claim(
        f"{robot}: {dof} always commutes",
        "III-C",
        "SCP = 1",
        said,
        float(last["ci_low"]),
        float(last["ci_high"]),
        last["scp"] >= ALMOST,
    )


def _nearest_half(robot: str, scene: str, scp: pd.DataFrame, config: Config) -> Claim | None:
    """Of the first joint of the arm, outwards from the base, at the reference threshold."""
    described = load_robot(config.apartment.robots[robot].description)
    arm = [joint.name for joint in described.joints if joint.kind != "prismatic"]
    first = next(
        (dof.name for dof in described.description.dofs if arm and arm[0] in dof.joints), None
    )
    rows = _rows(scp, robot, scene, config)
    rows = rows[
        (rows["dof"] == first) & (rows["threshold"] == config.apartment.reference.threshold)
    ]
    if rows.empty:
        return None
    row = rows.iloc[0]
    holds = bool(0.25 < row["scp"] < 0.75)
    return Claim(
        f"{robot}: the arm joint nearest the body has the SCP nearest .5",
        "IV-A",
        ".5",
        f"{first} {row['scp']:.3f}",
        row["ci_low"],
        row["ci_high"],
        holds,
    )


def _free(robot: str, scene: str, scp: pd.DataFrame, config: Config) -> Claim | None:
    rows = _rows(scp, robot, scene, config)
    if rows.empty:
        return None
    rows = rows[rows["threshold"] == rows["threshold"].min()]
    least = rows.loc[rows["scp"].idxmin()]
    said = f"least {least['dof']} {int(least['commuted'])} of {int(least['n'])} (threshold {least['threshold']:g})"
    return Claim(
        f"{robot}: in free space everything commutes",
        "II-D",
        "SCP = 1",
        said,
        least["ci_low"],
        least["ci_high"],
        bool(least["scp"] >= FREE),
    )


def _same_for_all_thresholds(order: pd.DataFrame) -> Claim | None:
    rows = order[order["changed"] == "threshold"]
    rows = rows[rows["value"].astype(float).between(*RANGE)]
    if rows.empty:
        return None
    if rows["tau"].isna().any():
        undefined = ", ".join(rows.loc[rows["tau"].isna(), "value"])
        return Claim(
            "the hierarchy is the same for all thresholds",
            "III-C",
            "20 to 100",
            f"undefined at {undefined}",
            None,
            None,
            False,
        )
    least = rows.loc[rows["tau"].idxmin()]
    said = f"least Kendall's tau {least['tau']:.2f} (threshold {least['value']})"
    interval = float(least["ci_low"]), float(least["ci_high"])
    return Claim(
        "the hierarchy is the same for all thresholds",
        "III-C",
        "20 to 100",
        said,
        *interval,
        bool(least["tau"] >= SAME),
    )
