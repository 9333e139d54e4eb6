"""The paper's claims about robots in apartments (section III-C, appendix C), each decided by a rule that was fixed before the run.

The paper names thresholds from 20 to 100; a claim holds if it holds at every threshold of the configuration in that range.

- "lowest": the SCP of every wheel is below that of every other degree of freedom;
- "rising": every step from one group to the next of the robot's hierarchy has the right sign and a Holm-adjusted p-value below ALPHA;
- "always commutes": the SCP is at least ALMOST at threshold 100, since at lower ones a hair's breadth of motion counts;
- "the same hierarchy": Kendall's tau with the reference is at least SAME at every threshold.
"""

from __future__ import annotations

import pandas as pd

from ..config import Config
from ..worlds.apartment.robot import load_robot
from .claims import Claim, p_of_claim

ALPHA = 0.01
ALMOST = 0.95
SAME = 0.8
RANGE = (20.0, 100.0)


def apartment_claims(tables: dict[str, pd.DataFrame], config: Config) -> list[Claim]:
    """All claims, from the tables apartment_scp, apartment_hierarchy and apartment_order."""
    settings = config.apartment
    reference = settings.reference
    claims = [
        *_of_robot(reference.robot, reference.scene, "III-C", tables, config),
        _still("torso-lift", reference.robot, reference.scene, tables["apartment_scp"], config),
        _same_for_all_thresholds(tables["apartment_order"]),
    ]
    for robot in settings.robots_compared.robots:
        for scene in settings.robots_compared.scenes:
            claims += _of_robot(robot, scene, "App. C", tables, config)
    return [claim for claim in claims if claim is not None]


def _rows(table: pd.DataFrame, robot: str, scene: str, config: Config) -> pd.DataFrame:
    """Of a robot in an apartment, at the thresholds in the paper's range."""
    settings = config.apartment
    chosen = (table["robot"] == robot) & (table["apartment"] == scene) & (table["start"] == "anywhere")
    chosen &= (table["length"] == settings.sequence_length) & (table["field_of_view"] == settings.fields_of_view[0])
    return table[chosen & table["threshold"].between(*RANGE)]


def _of_robot(robot: str, scene: str, section: str, tables: dict[str, pd.DataFrame], config: Config) -> list[Claim]:
    groups = load_robot(config.apartment.robots[robot].description).hierarchy
    wheels = next(iter(groups.values()))
    gaps = []
    for threshold, rows in _rows(tables["apartment_scp"], robot, scene, config).groupby("threshold"):
        scp = rows.set_index("dof")["scp"]
        gaps.append((scp.drop(wheels).min() - scp[wheels].max(), scp[wheels].max(), scp.drop(wheels).idxmin(), threshold))
    gap, top, neighbour, threshold = min(gaps)
    said = f"highest wheel {top:.2f}, next {neighbour} {top + gap:.2f} (threshold {threshold:g}, where it is closest)"
    steps = _rows(tables["apartment_hierarchy"], robot, scene, config)
    worst = steps.loc[steps["p_adjusted"].idxmax()]
    rising = bool(((steps["difference"] < 0) & (steps["p_adjusted"] < ALPHA)).all())
    smallest = steps.loc[steps["difference"].idxmax()]
    order = " < ".join(groups)
    least = f"{smallest['difference']:+.3f} [{smallest['ci_low']:+.3f}, {smallest['ci_high']:+.3f}]"
    told = f"smallest step {smallest['lower']} - {smallest['higher']} {least}, largest {p_of_claim(worst['p_adjusted'])}"
    return [
        Claim(f"{robot}: the wheels have the lowest SCP", section, "wheels lowest", said, None, None, bool(gap > 0)),
        Claim(f"{robot}: the SCP rises along {order}", section, "rising outward", told, None, None, rising),
    ]


def _still(dof: str, robot: str, scene: str, scp: pd.DataFrame, config: Config) -> Claim | None:
    rows = _rows(scp, robot, scene, config)
    rows = rows[rows["dof"] == dof]
    if rows.empty:
        return None
    last = rows.loc[rows["threshold"].idxmax()]
    said = f"{int(last['commuted'])} of {int(last['n'])} commuted at threshold {last['threshold']:g}"
    return Claim(f"{robot}: {dof} always commutes", "III-C", "SCP = 1", said, float(last["ci_low"]), float(last["ci_high"]), last["scp"] >= ALMOST)


def _same_for_all_thresholds(order: pd.DataFrame) -> Claim | None:
    rows = order[order["changed"] == "threshold"]
    rows = rows[rows["value"].astype(float).between(*RANGE)]
    if rows.empty:
        return None
    least = rows.loc[rows["tau"].idxmin()]
    said = f"least Kendall's tau {least['tau']:.2f} (threshold {least['value']})"
    interval = float(least["ci_low"]), float(least["ci_high"])
    return Claim("the hierarchy is the same for all thresholds", "III-C", "20 to 100", said, *interval, bool(least["tau"] >= SAME))
