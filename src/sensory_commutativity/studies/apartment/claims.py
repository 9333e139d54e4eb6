"""The paper's claims about robots in apartments (section III-C, appendix C), each decided by a rule
that was fixed before the run.

The paper names thresholds from 20 to 100; a claim holds if it holds at every threshold of the
configuration in that range.

- "Lowest": the SCP of every wheel is below that of every other degree of freedom.
- "Rising": every step from one group of the robot's hierarchy to the next has the right sign and a
  Holm-adjusted p-value below ALPHA.
- "Always commutes": the SCP is at least ALMOST_ONE at the highest of these thresholds, since at
  lower ones the slightest motion counts.
- "The same hierarchy": Kendall's tau with the reference is defined and at least SAME_ORDER at every
  threshold.

Two things that the paper implies are decided as well: in free space every degree of freedom
commutes, at the lowest of these thresholds, in at least FREE of the experiments; and of all degrees
of freedom the arm joint nearest the body has the SCP nearest .5, at the reference threshold. That
holds in part if it is the nearest among the joints of the arm alone.

A claim about several steps or thresholds holds in part if it is shown of some.
"""

from __future__ import annotations

import pandas as pd

from ..claims import Claim, decide, format_p
from ..config import Config

ALPHA = 0.01
ALMOST_ONE = 0.95
SAME_ORDER = 0.8
FREE = 0.99
THRESHOLDS = (20.0, 100.0)


def apartment_claims(tables: dict[str, pd.DataFrame], config: Config) -> list[Claim]:
    """All claims, from the tables apartment_scp, apartment_hierarchy and apartment_order."""
    settings = config.apartment
    robot, scene = settings.reference.robot, settings.reference.scene
    scp = tables["apartment_scp"]
    claims = [
        *_of_robot(robot, scene, "III-C", tables, config),
        _still("torso-lift", robot, scene, scp, config),
        _nearest_half(robot, scene, scp, config),
        _same_at_all_thresholds(tables["apartment_order"]),
    ]
    claims += [
        _free(robot, scene, scp, config)
        for robot in settings.free_space.robots
        for scene in settings.free_space.scenes
    ]
    for robot in settings.robots_compared.robots:
        for scene in settings.robots_compared.scenes:
            claims += _of_robot(robot, scene, "App. C", tables, config)
    return [claim for claim in claims if claim is not None]


def _rows(table: pd.DataFrame, robot: str, scene: str, config: Config) -> pd.DataFrame:
    """Rows of a robot in an apartment, at the thresholds in the paper's range."""
    settings = config.apartment
    return table[
        (table["robot"] == robot)
        & (table["apartment"] == scene)
        & (table["start"] == "anywhere")
        & (table["length"] == settings.sequence_length)
        & (table["field_of_view"] == settings.fields_of_view[0])
        & table["threshold"].between(*THRESHOLDS)
    ]


def _of_robot(
    robot: str, scene: str, section: str, tables: dict[str, pd.DataFrame], config: Config
) -> list[Claim]:
    from ...worlds.apartment.robots.loading import load_robot

    loaded = load_robot(config.apartment.robots[robot].description)
    groups = loaded.hierarchy
    wheels = [dof.name for dof in loaded.description.dofs if set(dof.joints) & set(loaded.wheels)]
    scp = _rows(tables["apartment_scp"], robot, scene, config)
    steps = _rows(tables["apartment_hierarchy"], robot, scene, config)
    if scp.empty:
        return []
    claims = [_wheels_lowest(robot, section, wheels, scp)] if wheels else []
    return claims + ([_rising(robot, section, groups, steps)] if len(groups) > 1 else [])


def _wheels_lowest(robot: str, section: str, wheels: list[str], rows: pd.DataFrame) -> Claim:
    gaps = []
    for threshold, group in rows.groupby("threshold"):
        scp = group.set_index("dof")["scp"]
        others = scp.drop(wheels)
        gap = others.min() - scp[wheels].max()
        gaps.append((gap, threshold, scp[wheels].idxmax(), others.idxmin()))
    gap, threshold, *pair = min(gaps)
    at_threshold = rows[rows["threshold"] == threshold].set_index("dof")
    wheel, other = (_with_interval(at_threshold.loc[dof]) for dof in pair)
    measured = (
        f"highest wheel {wheel}, next {pair[1]} {other} (threshold {threshold:g}, where it is "
        "closest)"
    )
    return Claim(
        f"{robot}: the wheels have the lowest SCP", section, "wheels lowest", measured, None, None,
        bool(gap > 0), rule="the highest wheel is below all others at every threshold",
        limits="an order of estimates; intervals may overlap",
        verdict=decide(sum(g > 0 for g, *_ in gaps), 1, len(gaps)),
    )  # fmt: skip


def _rising(robot: str, section: str, groups: dict[str, list[str]], steps: pd.DataFrame) -> Claim:
    largest_p = format_p(steps.loc[steps["p_adjusted"].idxmax(), "p_adjusted"])
    rising = bool(((steps["difference"] < 0) & (steps["p_adjusted"] < ALPHA)).all())
    smallest = steps.loc[steps["difference"].idxmax()]
    interval = f"[{smallest['ci_low']:+.3f}, {smallest['ci_high']:+.3f}]"
    measured = (
        f"smallest step {smallest['lower']} - {smallest['higher']} "
        f"{smallest['difference']:+.3f} {interval}, largest {largest_p}"
    )
    name = f"{robot}: the SCP rises along {' < '.join(groups)}"
    found = steps["p_adjusted"] < ALPHA
    met = int((found & (steps["difference"] < 0)).sum())
    return Claim(
        name, section, "rising outward", measured, None, None, rising,
        rule=f"every step at every threshold has the right sign, adjusted p below {ALPHA:g}",
        verdict=decide(met, int(found.sum()) - met, len(steps)),
    )  # fmt: skip


def _with_interval(row: pd.Series) -> str:
    return f"{row['scp']:.2f} [{row['ci_low']:.2f}, {row['ci_high']:.2f}]"


def _still(dof: str, robot: str, scene: str, scp: pd.DataFrame, config: Config) -> Claim | None:
    rows = _rows(scp, robot, scene, config)
    rows = rows[rows["dof"] == dof]
    if rows.empty:
        return None
    last = rows.loc[rows["threshold"].idxmax()]
    measured = (
        f"{int(last['commuted'])} of {int(last['n'])} commuted at threshold {last['threshold']:g}"
    )
    return Claim(
        f"{robot}: {dof} always commutes", "III-C", "SCP = 1", measured, float(last["ci_low"]),
        float(last["ci_high"]), last["scp"] >= ALMOST_ONE,
        rule=f"an SCP of at least {ALMOST_ONE:g} at the highest threshold",
        limits="at lower thresholds the slightest motion counts",
        verdict="holds" if last["scp"] >= ALMOST_ONE else "not shown"
        if last["ci_high"] >= ALMOST_ONE else "does not hold",
    )  # fmt: skip


def _nearest_half(robot: str, scene: str, scp: pd.DataFrame, config: Config) -> Claim | None:
    """Which SCP is nearest .5: of all degrees of freedom and of the arm's, at every threshold."""
    from ...worlds.apartment.robots.loading import load_robot

    loaded = load_robot(config.apartment.robots[robot].description)
    joints = [joint.name for joint in loaded.joints if joint.kind != "prismatic"]
    arm = [
        dof.name
        for dof in loaded.description.dofs
        if set(dof.joints) & set(joints) and not set(dof.joints) & set(loaded.wheels)
    ]
    rows = _rows(scp, robot, scene, config)
    first = arm[0] if arm else None
    reference = rows[
        (rows["dof"] == first) & (rows["threshold"] == config.apartment.reference.threshold)
    ]
    if reference.empty:
        return None
    nearest, of_arm = nearest_half(rows), nearest_half(rows[rows["dof"].isin(arm)])
    threshold = config.apartment.reference.threshold
    row, met = reference.iloc[0], nearest[threshold] == first
    others = ", ".join(
        f"{t:g}: {dof}{'' if dof == of_arm[t] else f' (arm {of_arm[t]})'}"
        for t, dof in nearest.items()
    )
    return Claim(
        f"{robot}: the arm joint nearest the body has the SCP nearest .5", "IV-A", ".5",
        f"{first} {row['scp']:.3f}; nearest by threshold: {others}", row["ci_low"], row["ci_high"],
        bool(met),
        rule=f"of all degrees of freedom its SCP is nearest .5 at threshold {threshold:g}",
        limits="wheels move the camera; among the joints of the arm alone it is "
        f"{'the' if of_arm[threshold] == first else 'not the'} nearest",
        verdict=decide(int(met) + int(of_arm[threshold] == first), 1, 2),
    )  # fmt: skip


def nearest_half(rows: pd.DataFrame) -> dict[float, str]:
    """Threshold -> the degree of freedom whose SCP is nearest one half, the first if equal."""
    return {
        float(threshold): str(group.loc[(group["scp"] - 0.5).abs().idxmin(), "dof"])
        for threshold, group in rows.groupby("threshold")
    }


def _free(robot: str, scene: str, scp: pd.DataFrame, config: Config) -> Claim | None:
    rows = _rows(scp, robot, scene, config)
    if rows.empty:
        return None
    rows = rows[rows["threshold"] == rows["threshold"].min()]
    least = rows.loc[rows["scp"].idxmin()]
    measured = (
        f"least {least['dof']} {int(least['commuted'])} of {int(least['n'])} "
        f"(threshold {least['threshold']:g})"
    )
    return Claim(
        f"{robot}: in free space everything commutes", "II-D", "SCP = 1", measured,
        least["ci_low"], least["ci_high"], bool(least["scp"] >= FREE),
        rule=f"every SCP is at least {FREE:g} at the lowest threshold",
    )  # fmt: skip


def _same_at_all_thresholds(order: pd.DataFrame) -> Claim | None:
    claim = ("the hierarchy is the same for all thresholds", "III-C", "20 to 100")
    rule = f"Kendall's tau with the order of the reference is at least {SAME_ORDER} at each"
    rows = order[order["changed"] == "threshold"]
    rows = rows[rows["value"].astype(float).between(*THRESHOLDS)]
    if rows.empty:
        return None
    if rows["tau"].isna().any():
        undefined = ", ".join(rows.loc[rows["tau"].isna(), "value"])
        return Claim(
            *claim, f"undefined at {undefined}", None, None, False, rule=rule,
            verdict="not shown",
        )  # fmt: skip
    least = rows.loc[rows["tau"].idxmin()]
    measured = f"least Kendall's tau {least['tau']:.2f} (threshold {least['value']})"
    return Claim(
        *claim, measured, float(least["ci_low"]), float(least["ci_high"]),
        bool(least["tau"] >= SAME_ORDER), rule=rule,
        verdict=decide(int((rows["tau"] >= SAME_ORDER).sum()), 1, len(rows)),
    )  # fmt: skip
