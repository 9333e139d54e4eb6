"""The paper's claims, each decided by a rule that was fixed before the run; those about robots and about
learning are in :mod:`.apartment_claims` and :mod:`.navigation_claims`.

The paper prints its SCP values as bars only, so most claims are orders and equalities. The rules:

- "always commutes", "commutes with everything": all experiments did; "does not": at least one did not;
- an order of SCPs or a trend: every difference or slope has the right sign and a Holm-adjusted p-value below ALPHA;
- left equals right: both 95 % intervals of the paired differences contain 0;
- "almost all is 1": every SCP is at least ALMOST;
- naive change: the head is among the two highest of the eight;
- harder to predict: the difference of the mean test errors has the right sign and p below ALPHA, two-sided z-test with sequences as units.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import norm

from ....storage.tables import TABLES, read_table, write_table
from ...apartment.claims import apartment_claims
from ...catalogue import COMPARED
from ...claims import Claim, p_of_claim
from ...config import Config
from ...flatland.hierarchy import ALPHA, HIERARCHY, LEFT_AND_RIGHT, ordered_difference
from ...navigation.claims import navigation_claims
from ...objects.claims import mask_claims

ALMOST = 0.9
STILL = ("head", "eyelid")
ARMS = ("left-shoulder", "right-shoulder", "left-elbow", "right-elbow")


def compare_with_paper(tables: dict[str, pd.DataFrame], config: Config) -> list[Claim]:
    """All claims, in the order of the paper."""
    reference = config.flatland.reference
    scp = tables["flatland_scp"]
    scp = scp[scp["threshold"] == 0]
    mine = scp[(scp["world"] == reference.world) & (scp["agent"] == reference.agent)].set_index(
        "dof"
    )
    pairs = tables["flatland_comparisons"]
    pairs = pairs[(pairs["world"] == reference.world) & (pairs["agent"] == reference.agent)]
    return [
        *_still_and_moving(mine),
        *[_step(name, steps, pairs) for name, steps in HIERARCHY.items()],
        _left_equals_right(pairs),
        *_appendix_b(scp, tables["flatland_trends"], config),
        _philipona(
            tables["flatland_commutation"], reference.world, "where things move by themselves"
        ),
        _philipona(
            tables["flatland_commutation"],
            config.flatland.commutation.settled_world,
            "where nothing moves by itself",
        ),
        *_alternatives(
            tables["flatland_baselines"].set_index("dof"),
            tables["flatland_alternatives"].set_index("alternative"),
        ),
        *apartment_claims(tables, config),
        *mask_claims(tables, config),
        *navigation_claims(tables["navigation_summary"], tables["navigation_comparisons"], config),
    ]


def _still_and_moving(mine: pd.DataFrame) -> list[Claim]:
    still, others = mine.loc[list(STILL)], mine.drop(index=list(STILL))
    equal = bool((still["commuted"] == still["n"]).all())
    lowest = float(still["ci_low"].min())
    said = f"{int(still['commuted'].sum()):,} of {int(still['n'].sum()):,} commuted"
    top = others.loc[others["scp"].idxmax()]
    return [
        Claim("head and eyelid always commute", "III-C", "SCP = 1", said, lowest, 1.0, equal),
        Claim(
            "every other degree of freedom does not", "III-C", "SCP < 1", f"highest {top['scp']:.4f} ({others['scp'].idxmax()})",
            float(top["ci_low"]), float(top["ci_high"]), bool((others["commuted"] < others["n"]).all()),
        ),
    ]  # fmt: skip


def _step(name: str, steps: tuple[tuple[str, str], ...], pairs: pd.DataFrame) -> Claim:
    found = [ordered_difference(pairs, low, high) for low, high in steps]
    smallest = max(found, key=lambda f: f.difference)
    worst_p = max(f.p_adjusted for f in found)
    holds = all(f.difference < 0 and f.p_adjusted < ALPHA for f in found)
    said = f"smallest difference {smallest.difference:+.4f}, largest {p_of_claim(worst_p)}"
    return Claim(name, "III-C", "order", said, smallest.ci_low, smallest.ci_high, holds)


def _left_equals_right(pairs: pd.DataFrame) -> Claim:
    found = [ordered_difference(pairs, low, high) for low, high in LEFT_AND_RIGHT]
    largest = max(found, key=lambda f: abs(f.difference))
    holds = all(f.ci_low <= 0 <= f.ci_high for f in found)
    return Claim(
        "left and right commute equally",
        "III-C",
        "equal",
        f"largest difference {largest.difference:+.4f}",
        largest.ci_low,
        largest.ci_high,
        holds,
    )


def _appendix_b(scp: pd.DataFrame, trends: pd.DataFrame, config: Config) -> list[Claim]:
    combinations, worlds = config.flatland.combinations, config.flatland.worlds
    empty = [
        world for world in combinations.worlds if worlds[world].objects == 0 and worlds[world].walls
    ]
    claims = []
    if empty:
        rows = scp[scp["world"].isin(empty) & scp["agent"].isin(combinations.agents)]
        lowest = rows.loc[rows["scp"].idxmin()]
        said = f"lowest {lowest['scp']:.4f} ({lowest['dof']}, {lowest['agent']})"
        interval = float(lowest["ci_low"]), float(lowest["ci_high"])
        claims.append(
            Claim(
                "in the closed empty room almost all is 1",
                "App. B",
                "about 1",
                said,
                *interval,
                bool((rows["scp"] >= ALMOST).all()),
            )
        )
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
            said = f"smallest change {rows['effect'].max():+.4f}{unit}, largest {p_of_claim(rows['p_adjusted'].max())}"
            holds = bool(((rows["effect"] < 0) & (rows["p_adjusted"] < ALPHA)).all())
            claims.append(Claim(name, "App. B", "falls", said, None, None, holds))
    return claims


def _philipona(commutation: pd.DataFrame, world: str, where: str) -> Claim:
    rows = commutation[
        (commutation["dof_a"].isin(STILL) | commutation["dof_b"].isin(STILL))
        & (commutation["world"] == world)
    ]
    lowest = rows.loc[rows["probability"].idxmin()]
    said = f"lowest {lowest['probability']:.4f} ({lowest['dof_a']}, {lowest['dof_b']})"
    return Claim(
        f"what displaces nothing commutes with everything, {where}", "II-C", "conjecture", said,
        float(lowest["ci_low"]), float(lowest["ci_high"]), bool((rows["commuted"] == rows["n"]).all()),
    )  # fmt: skip


def _alternatives(baselines: pd.DataFrame, alternatives: pd.DataFrame) -> list[Claim]:
    naive, excess = baselines["naive_mse"], baselines["excess_error"]
    rank = int((naive > naive["head"]).sum()) + 1
    order = {
        name: f"rank correlation with 1 - SCP {alternatives.loc[name, 'spearman']:+.2f}"
        for name in alternatives.index
    }

    def harder(dof: str, paper_value: str) -> Claim:
        easy = "base-longitudinal"
        difference = float(excess[dof] - excess[easy])
        spread = float(
            np.hypot(baselines.loc[dof, "prediction_se"], baselines.loc[easy, "prediction_se"])
        )
        p = float(2 * norm.sf(abs(difference) / spread))
        said = f"excess error {excess[dof]:.0f} against {excess[easy]:.0f}, {p_of_claim(p)}; {order['excess prediction error']}"
        name = f"{dof.replace('-', ' ')} is harder to predict than base longitudinal"
        return Claim(name, "App. A", paper_value, said, None, None, difference > 0 and p < ALPHA)

    return [
        Claim(
            "naive change: the head is among the two highest, though it displaces nothing", "App. A", "head changes the view dramatically",
            f"head ranks {rank} of {len(naive)}; {order['naive change']}", None, None, rank <= 2,
        ),
        harder("head", "head above base longitudinal"),
        harder("base-rotation", "a great difference"),
    ]  # fmt: skip


def write_paper_comparison(tables: Path, out: Path, config: Config) -> None:
    """Compare the tables in the folder `tables` with the paper and write the table paper_comparison."""
    frames = {name: read_table(name, tables / f"{name}.parquet") for name in COMPARED}
    claims = compare_with_paper(frames, config)
    columns = [column.name for column in TABLES["paper_comparison"]]
    frame = pd.DataFrame([claim._asdict() for claim in claims], columns=columns).astype(
        {"ci_low": float, "ci_high": float}
    )
    write_table("paper_comparison", frame, out, config)
