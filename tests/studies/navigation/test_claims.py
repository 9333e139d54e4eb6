"""The paper's claims about learning to navigate hold and fail as their rules say."""

from __future__ import annotations

import numpy as np
import pandas as pd

from sensory_commutativity.studies.navigation.claims import navigation_claims
from sensory_commutativity.studies.navigation.tables.navigation_comparisons import (
    HALF,
    LOG_RANK,
    STEPS,
    WELCH,
    navigation_comparisons,
)
from sensory_commutativity.studies.navigation.tables.navigation_sensitivity import (
    navigation_sensitivity,
)
from sensory_commutativity.studies.navigation.tables.navigation_summary import navigation_summary

TWICE = "SCP-truncated learns more than twice as fast as the full action space"
FASTER = "SCP-adapted learns faster than the full action space"
SLOWER = "SCP-adapted learns slower than SCP-truncated"
PAIRS = [("truncated", "full"), ("adapted", "full"), ("truncated", "adapted")]


def make_rows(table, rows: list[dict]) -> pd.DataFrame:
    return pd.DataFrame(rows, columns=table.column_names)


def make_sensitivity(ratio_at_45: float = 0.4, confirmation: bool = True) -> pd.DataFrame:
    """A table navigation_sensitivity in which the ratio is below a half, but perhaps at 45."""
    rows = []
    for runs in ("all", "first look", "confirmation") if confirmation else ("all",):
        for threshold in (10.0, 25.0, 35.0, 45.0):
            ratio = ratio_at_45 if threshold == 45 else 0.4
            rows.append(dict(runs=runs, threshold=threshold, a="truncated", b="full", n=30,
                             ratio=ratio, ci_low=ratio - 0.05, ci_high=ratio + 0.05, p=1e-6,
                             p_half=0.006))  # fmt: skip
    return make_rows(navigation_sensitivity, rows)


def test_the_claim_of_twice_as_fast_says_whether_it_depends_on_the_threshold(default_config):
    def twice(sensitivity: pd.DataFrame):
        claims = navigation_claims(*make_tables(60), sensitivity, default_config)
        return next(claim for claim in claims if claim.claim == TWICE)

    assert twice(make_sensitivity()).verdict == "holds"
    claim = twice(make_sensitivity(0.47))
    assert claim.holds and claim.verdict == "holds in part" and "0.47 at 45" in claim.limits
    assert "the 30 seeds drawn after the first look alone: 0.40 [0.35, 0.45]" in claim.our_value
    assert "first look" not in twice(make_sensitivity(confirmation=False)).our_value


def make_tables(n: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tables navigation_summary and navigation_comparisons of n runs, in which all claims hold."""
    summary = make_rows(
        navigation_summary,
        [dict(action_space=space, measure=measure, n=n, mean=1.0)
         for space in ("full", "truncated", "adapted") for measure in ("reached", "solved")],
    )  # fmt: skip
    significant = dict(measure=STEPS, p=1e-9, p_adjusted=1e-9)
    rows = [dict(a="truncated", b="full", test=HALF, statistic=-9.0, ci_low=0.3, ci_high=0.4,
                 effect_size=0.35, **significant)]  # fmt: skip
    for a, b in PAIRS:
        rows.append(dict(a=a, b=b, test=WELCH, statistic=-9.0, difference=-5000.0, ci_low=-6000.0,
                         ci_high=-4000.0, effect_size=-3.0, **significant))  # fmt: skip
        rows.append(dict(a=a, b=b, test=LOG_RANK, statistic=5.0, **significant))
    return summary, make_rows(navigation_comparisons, rows)


def test_claims_hold_and_fail_one_by_one(default_config):
    alpha = default_config.navigation.alpha
    tables = make_tables(len(default_config.navigation.seeds))
    claims = navigation_claims(*tables, make_sensitivity(), default_config)
    assert [claim.claim for claim in claims if not claim.holds] == []
    assert len({claim.claim for claim in claims}) == 4
    assert all(claim.section and claim.paper_value and claim.our_value for claim in claims)
    for k, values, changes, failing in (
        (0, dict(action_space="full", measure="reached"), dict(mean=0.25),
         "every action space can solve the task"),
        (1, dict(test=HALF), dict(ci_high=0.51), TWICE),
        (1, dict(test=HALF), dict(p_adjusted=1.2 * alpha), TWICE),
        (1, dict(test=HALF), dict(statistic=9.0), TWICE),
        (1, dict(test=LOG_RANK, a="truncated", b="full"), dict(p_adjusted=1.2 * alpha), TWICE),
        (1, dict(test=WELCH, a="adapted"), dict(difference=100.0), FASTER),
        (1, dict(test=LOG_RANK, a="adapted"), dict(p_adjusted=1.2 * alpha), FASTER),
        (1, dict(test=LOG_RANK, b="adapted"), dict(statistic=-5.0), SLOWER),
        (1, dict(test=WELCH, b="adapted"), dict(p_adjusted=1.2 * alpha), SLOWER),
    ):  # fmt: skip
        rows = np.logical_and.reduce([tables[k][key] == value for key, value in values.items()])
        assert rows.any(), values
        changed = list(tables)
        changed[k] = tables[k].assign(
            **{key: tables[k][key].mask(rows, value) for key, value in changes.items()}
        )
        claims = navigation_claims(*changed, make_sensitivity(), default_config)
        assert [claim.claim for claim in claims if not claim.holds] == [failing], (values, changes)
