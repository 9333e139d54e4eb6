"""The paper's claims about Flatland (sections II-C and III-C, appendices A and B).

The paper prints its SCP values as bars only, so most claims are orders and equalities. Each is
decided by a rule that was fixed before the run:

- "always commutes", "commutes with everything": all experiments did; "does not": at least one did
  not;
- an order of SCPs or a trend: every difference or slope has the right sign and a Holm-adjusted
  p-value below ALPHA;
- left equals right: both 95 % intervals of the paired differences contain 0;
- "almost all is 1": every SCP is at least ALMOST_ONE;
- naive change: the head is among the two highest of the eight;
- harder to predict: the difference of the mean test errors has the right sign and p below ALPHA,
  two-sided z-test with sequences as units.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from ..claims import Claim, format_p
from ..config import Config
from .hierarchy import ALPHA, HIERARCHY, LEFT_AND_RIGHT, STILL, find_difference

ALMOST_ONE = 0.9
ARMS = ("left-shoulder", "right-shoulder", "left-elbow", "right-elbow")


def flatland_claims(tables: dict[str, pd.DataFrame], config: Config) -> list[Claim]:
    """All claims about Flatland, in the order of the paper; `tables` by name."""
    reference, settled = config.flatland.reference, config.flatland.commutation.settled_world
    scp = tables["flatland_scp"]
    scp = scp[scp["threshold"] == 0]
    pairs = tables["flatland_comparisons"]

    def of_reference(rows: pd.DataFrame) -> pd.DataFrame:
        return rows[(rows["world"] == reference.world) & (rows["agent"] == reference.agent)]

    pairs = of_reference(pairs)
    commutation = tables["flatland_commutation"]
    return [
        *_still_and_moving(of_reference(scp).set_index("dof")),
        *[_step(name, steps, pairs) for name, steps in HIERARCHY.items()],
        _left_equals_right(pairs),
        *_appendix_b(scp, tables["flatland_trends"], config),
        _philipona(commutation, reference.world, "where things move by themselves"),
        _philipona(commutation, settled, "where nothing moves by itself"),
        *_alternatives(
            tables["flatland_baselines"].set_index("dof"),
            tables["flatland_alternatives"].set_index("alternative"),
        ),
    ]


def _still_and_moving(scp: pd.DataFrame) -> list[Claim]:
    still, others = scp.loc[list(STILL)], scp.drop(index=list(STILL))
    equal = bool((still["commuted"] == still["n"]).all())
    lowest = float(still["ci_low"].min())
    measured = f"{int(still['commuted'].sum()):,} of {int(still['n'].sum()):,} commuted"
    highest = others.loc[others["scp"].idxmax()]
    return [
        Claim("head and eyelid always commute", "III-C", "SCP = 1", measured, lowest, 1.0, equal),
        Claim(
            "every other degree of freedom does not", "III-C", "SCP < 1",
            f"highest {highest['scp']:.4f} ({others['scp'].idxmax()})",
            float(highest["ci_low"]), float(highest["ci_high"]),
            bool((others["commuted"] < others["n"]).all()),
        ),
    ]  # fmt: skip


def _step(name: str, steps: tuple[tuple[str, str], ...], pairs: pd.DataFrame) -> Claim:
    differences = [find_difference(pairs, low, high) for low, high in steps]
    smallest = max(differences, key=lambda d: d.difference)
    largest_p = max(d.p_adjusted for d in differences)
    holds = all(d.difference < 0 and d.p_adjusted < ALPHA for d in differences)
    measured = f"smallest difference {smallest.difference:+.4f}, largest {format_p(largest_p)}"
    return Claim(name, "III-C", "order", measured, smallest.ci_low, smallest.ci_high, holds)


def _left_equals_right(pairs: pd.DataFrame) -> Claim:
    differences = [find_difference(pairs, low, high) for low, high in LEFT_AND_RIGHT]
    largest = max(differences, key=lambda d: abs(d.difference))
    holds = all(d.ci_low <= 0 <= d.ci_high for d in differences)
    return Claim(
        "left and right commute equally", "III-C", "equal",
        f"largest difference {largest.difference:+.4f}", largest.ci_low, largest.ci_high, holds,
    )  # fmt: skip


def _appendix_b(scp: pd.DataFrame, trends: pd.DataFrame, config: Config) -> list[Claim]:
    combinations, worlds = config.flatland.combinations, config.flatland.worlds
    empty = [w for w in combinations.worlds if worlds[w].objects == 0 and worlds[w].walls]
    claims = []
    if empty:
        rows = scp[scp["world"].isin(empty) & scp["agent"].isin(combinations.agents)]
        lowest = rows.loc[rows["scp"].idxmin()]
        claims.append(
            Claim(
                "in the closed empty room almost all is 1", "App. B", "about 1",
                f"lowest {lowest['scp']:.4f} ({lowest['dof']}, {lowest['agent']})",
                float(lowest["ci_low"]), float(lowest["ci_high"]),
                bool((rows["scp"] >= ALMOST_ONE).all()),
            )
        )  # fmt: skip
    for trend, name, unit in (
        (
            "more objects",
            "SCP of shoulders and elbows falls with the number of objects",
            " per object",
        ),
        ("longer arms", "SCP of shoulders and elbows falls with arm length", ""),
    ):
        rows = trends[(trends["trend"] == trend) & trends["dof"].isin(ARMS)]
        if len(rows):
            largest_p = format_p(rows["p_adjusted"].max())
            measured = f"smallest change {rows['effect'].max():+.4f}{unit}, largest {largest_p}"
            holds = bool(((rows["effect"] < 0) & (rows["p_adjusted"] < ALPHA)).all())
            claims.append(Claim(name, "App. B", "falls", measured, None, None, holds))
    return claims


def _philipona(commutation: pd.DataFrame, world: str, where: str) -> Claim:
    still = commutation["dof_a"].isin(STILL) | commutation["dof_b"].isin(STILL)
    rows = commutation[still & (commutation["world"] == world)]
    lowest = rows.loc[rows["probability"].idxmin()]
    return Claim(
        f"what displaces nothing commutes with everything, {where}", "II-C", "conjecture",
        f"lowest {lowest['probability']:.4f} ({lowest['dof_a']}, {lowest['dof_b']})",
        float(lowest["ci_low"]), float(lowest["ci_high"]),
        bool((rows["commuted"] == rows["n"]).all()),
    )  # fmt: skip


def _alternatives(baselines: pd.DataFrame, alternatives: pd.DataFrame) -> list[Claim]:
    from scipy.stats import norm

    naive, excess = baselines["naive_mse"], baselines["excess_error"]
    rank = int((naive > naive["head"]).sum()) + 1
    correlation = {
        name: f"rank correlation with 1 - SCP {alternatives.loc[name, 'spearman']:+.2f}"
        for name in alternatives.index
    }

    def harder(dof: str, paper_value: str) -> Claim:
        easy = "base-longitudinal"
        difference = float(excess[dof] - excess[easy])
        errors = baselines.loc[dof, "prediction_se"], baselines.loc[easy, "prediction_se"]
        p = float(2 * norm.sf(abs(difference) / float(np.hypot(*errors))))
        measured = (
            f"excess error {excess[dof]:.0f} against {excess[easy]:.0f}, {format_p(p)}; "
            f"{correlation['excess prediction error']}"
        )
        name = f"{dof.replace('-', ' ')} is harder to predict than base longitudinal"
        holds = difference > 0 and p < ALPHA
        return Claim(name, "App. A", paper_value, measured, None, None, holds)

    return [
        Claim(
            "naive change: the head is among the two highest, though it displaces nothing",
            "App. A", "head changes the view dramatically",
            f"head ranks {rank} of {len(naive)}; {correlation['naive change']}",
            None, None, rank <= 2,
        ),
        harder("head", "head above base longitudinal"),
        harder("base-rotation", "a great difference"),
    ]  # fmt: skip
