"""The paper's claims about Flatland hold and fail as their rules say."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.statistics.proportions import wilson_interval
from sensory_commutativity.studies.claims import VERDICTS
from sensory_commutativity.studies.flatland.claims import flatland_claims
from sensory_commutativity.studies.flatland.hierarchy import (
    HIERARCHY,
    LEFT_AND_RIGHT,
    find_difference,
)
from sensory_commutativity.studies.registry import find_table
from tests.helpers import DOFS

EXCESS = dict(zip(DOFS, [10.0, 60, 50, 5, 20, 30, 20, 30], strict=True))
STILL = {"head", "eyelid"}


def frame(name: str, rows: list[tuple]) -> pd.DataFrame:
    return pd.DataFrame(rows, columns=find_table(name).column_names)


@pytest.fixture
def tables(tiny_config) -> dict[str, pd.DataFrame]:
    """Tables in which every claim holds."""
    n, agents = 10_000, tiny_config.flatland.combinations.agents
    counts = [7000, 7200, 10_000, 10_000, 8000, 9000, 8000, 9000]
    low, high = wilson_interval(np.array(counts), np.full(8, n))
    scp = [
        ("furnished", "polyphemus", 4, dof, 0.0, n, k, k / n, *ends)
        for dof, k, *ends in zip(DOFS, counts, low, high, strict=True)
    ]
    scp += [("things-0", agent, 4, dof, 0.0, 100, 99, 0.99, 0.95, 1.0)
            for agent in agents for dof in DOFS]  # fmt: skip
    comparisons = []
    for i, a in enumerate(DOFS):
        for j in range(i + 1, 8):
            d = (counts[i] - counts[j]) / n
            p = 1e-9 if d else 1.0
            comparisons.append(("furnished", "polyphemus", a, DOFS[j], "McNemar, exact", n, 1, 1,
                                d, d - 0.01, d + 0.01, p, p))  # fmt: skip
    arms = DOFS[4:]
    trends = [("more objects", agent, dof, "x", -9.0, -0.01, 1e-9, 1e-9)
              for agent in agents for dof in arms]  # fmt: skip
    trends += [("longer arms", "all worlds", dof, "x", 0.5, -0.1, 1e-9, 1e-9) for dof in arms]
    # the paper says nothing about the base
    trends.append(("longer arms", "all worlds", "base-rotation", "x", 1.0, 0.1, 1.0, 1.0))
    commutation = [
        (world, a, b, 100, k, k / 100, 0.4, 1.0)
        for world in ("furnished", "settled")
        for a in DOFS
        for b in DOFS
        for k in [100 if {a, b} & STILL else 50]
    ]
    baselines = [(dof, e, 0.1, 100 + e, 0.1, e, 100, 20) for dof, e in EXCESS.items()]
    alternatives = [("naive change", 8, 0.1, 0.1, 0.8),
                    ("excess prediction error", 8, 0.2, 0.2, 0.7)]  # fmt: skip
    return {
        "flatland_scp": frame("flatland_scp", scp),
        "flatland_comparisons": frame("flatland_comparisons", comparisons),
        "flatland_trends": frame("flatland_trends", trends),
        "flatland_commutation": frame("flatland_commutation", commutation),
        "flatland_baselines": frame("flatland_baselines", baselines),
        "flatland_alternatives": frame("flatland_alternatives", alternatives),
    }


def test_all_claims_hold_if_everything_is_as_in_the_paper(tables, tiny_config):
    claims = flatland_claims(tables, tiny_config)
    assert [claim.claim for claim in claims if not claim.holds] == []
    assert len(claims) == len({claim.claim for claim in claims}) == 14
    for claim in claims:
        assert claim.section and claim.paper_value and claim.our_value
        assert (claim.ci_low is None) == (claim.ci_high is None)
        assert claim.ci_low is None or claim.ci_low <= claim.ci_high


SCP, PAIRS, BASELINES = "flatland_scp", "flatland_comparisons", "flatland_baselines"
COMMUTES = "what displaces nothing commutes with everything, where "
VIOLATIONS = [
    (SCP, dict(world="furnished", dof="head"), dict(commuted=9999, scp=0.9999),
     "head and eyelid always commute"),
    (SCP, dict(world="furnished", dof="left-elbow"), dict(commuted=10_000, scp=1.0),
     "every other degree of freedom does not"),
    (SCP, dict(world="things-0", dof="left-elbow"), dict(scp=0.89),
     "in the closed empty room almost all is 1"),
    (PAIRS, dict(dof_a="base-rotation", dof_b="left-elbow"), dict(difference=0.2),
     "base below elbows"),
    (PAIRS, dict(dof_a="base-rotation", dof_b="left-elbow"), dict(p_adjusted=0.002),
     "base below elbows"),
    (PAIRS, dict(dof_a="left-shoulder", dof_b="right-elbow"), dict(difference=0.1),
     "shoulders below elbows"),
    (PAIRS, dict(dof_a="head", dof_b="left-elbow"), dict(difference=-0.1),
     "elbows below head and eyelid"),
    (PAIRS, dict(dof_a="left-elbow", dof_b="right-elbow"), dict(only_a=180),
     "left and right commute equally"),
    ("flatland_trends", dict(trend="more objects", dof="left-elbow"), dict(effect=0.01),
     "SCP of shoulders and elbows falls with the number of objects"),
    ("flatland_trends", dict(trend="longer arms", dof="left-elbow"), dict(p_adjusted=0.01),
     "SCP of shoulders and elbows falls with arm length"),
    ("flatland_commutation", dict(world="furnished", dof_a="head", dof_b="left-elbow"),
     dict(commuted=99, probability=0.99), COMMUTES + "things move by themselves"),
    ("flatland_commutation", dict(world="settled", dof_a="left-elbow", dof_b="eyelid"),
     dict(commuted=99, probability=0.99), COMMUTES + "nothing moves by itself"),
    (BASELINES, dict(dof="head"), dict(naive_mse=15.0),
     "naive change: the head is among the two highest, though it displaces nothing"),
    (BASELINES, dict(dof="head"), dict(prediction_se=20.0),
     "head is harder to predict than base longitudinal"),
    (BASELINES, dict(dof="head"), dict(excess_error=9.0),
     "head is harder to predict than base longitudinal"),
    (BASELINES, dict(dof="base-rotation"), dict(excess_error=10.0),
     "base rotation is harder to predict than base longitudinal"),
]  # fmt: skip


def test_a_claim_fails_if_its_condition_is_violated(tables, tiny_config):
    for name, values, changes, failing in VIOLATIONS:
        rows = np.logical_and.reduce([tables[name][key] == v for key, v in values.items()])
        assert rows.any(), values
        changed = tables[name].copy()
        for column, value in changes.items():
            changed.loc[rows, column] = value
        claims = flatland_claims({**tables, name: changed}, tiny_config)
        assert [claim.claim for claim in claims if not claim.holds] == [failing], (values, changes)


def test_left_and_right_are_equal_only_if_that_is_shown(tables, tiny_config):
    """Few starts show no difference, and no equality either."""
    name = "left and right commute equally"

    def verdict(**values: float) -> str | None:
        changed = tables[PAIRS].assign(**values)
        claims = flatland_claims({**tables, PAIRS: changed}, tiny_config)
        return next(claim.verdict for claim in claims if claim.claim == name)

    assert verdict() == "holds" and verdict(n=20) == "not shown"
    assert verdict(only_a=800, ci_low=0.07, ci_high=0.09) == "does not hold"


def test_every_claim_says_its_rule(tables, tiny_config):
    for claim in flatland_claims(tables, tiny_config):
        assert claim.rule and claim.row()["verdict"] in VERDICTS
    harder = [c for c in flatland_claims(tables, tiny_config) if "harder to predict" in c.claim]
    assert {c.verdict for c in harder} == {"holds in part"}
    assert all("no change for 8 of 8" in c.limits for c in harder)


def test_a_difference_is_found_in_either_direction():
    columns = ["dof_a", "dof_b", "difference", "ci_low", "ci_high", "p_adjusted", "n", "only_a",
               "only_b"]  # fmt: skip
    rows = [("head", "left-elbow", 0.3, 0.1, 0.4, 0.02, 50, 20, 5),
            ("head", "eyelid", 0, -0.1, 0.2, 1, 9, 1, 1)]  # fmt: skip
    pairs = pd.DataFrame(rows, columns=columns)
    assert find_difference(pairs, "head", "left-elbow") == (0.3, 0.1, 0.4, 0.02, 50, 20, 5)
    assert find_difference(pairs, "left-elbow", "head") == (-0.3, -0.4, -0.1, 0.02, 50, 5, 20)


def test_the_hierarchy_orders_all_dofs_without_a_circle():
    """Base and shoulders below elbows, elbows below head and eyelid (section III-C)."""
    rank = {dof: 1 if "elbow" in dof else 2 if dof in STILL else 0 for dof in DOFS}
    steps = [pair for pairs in HIERARCHY.values() for pair in pairs]
    assert len(steps) == 12 and all(rank[low] + 1 == rank[high] for low, high in steps)
    assert {dof for pair in steps for dof in pair} == set(DOFS)
    assert all(rank[a] == rank[b] and a != b for a, b in LEFT_AND_RIGHT)
