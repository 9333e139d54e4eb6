"""From SC-experiments in Flatland to SCP, comparisons, trends and correlations; answers by hand."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.statistics import ranks
from sensory_commutativity.statistics.paired import holm
from sensory_commutativity.statistics.proportions import wilson_interval
from sensory_commutativity.statistics.trends import cochran_armitage, mantel_haenszel
from sensory_commutativity.studies.flatland.tables.flatland_alternatives import (
    flatland_alternatives,
)
from sensory_commutativity.studies.flatland.tables.flatland_baselines import flatland_baselines
from sensory_commutativity.studies.flatland.tables.flatland_commutation import flatland_commutation
from sensory_commutativity.studies.flatland.tables.flatland_commutation_experiments import (
    flatland_commutation_experiments,
)
from sensory_commutativity.studies.flatland.tables.flatland_comparisons import (
    compare_dofs,
    flatland_comparisons,
)
from sensory_commutativity.studies.flatland.tables.flatland_experiments import flatland_experiments
from sensory_commutativity.studies.flatland.tables.flatland_scp import flatland_scp
from sensory_commutativity.studies.flatland.tables.flatland_sensitivity import flatland_sensitivity
from sensory_commutativity.studies.flatland.tables.flatland_trends import (
    ARM_LENGTH,
    OBJECTS,
    flatland_trends,
)
from tests.helpers import DOFS, update_flatland


def make_experiments(
    distances: dict[str, list[float]],
    world: str = "furnished",
    agent: str = "polyphemus",
    length: int = 4,
) -> pd.DataFrame:
    """A table flatland_experiments with these distances for each degree of freedom."""
    rows = [
        (world, agent, length, dof, i, i, distance)
        for dof, values in distances.items()
        for i, distance in enumerate(values)
    ]
    return pd.DataFrame(rows, columns=flatland_experiments.column_names)


# ---- SCP --------------------------------------------------------------------------------------


def test_the_scp_is_counted_at_the_main_length_at_every_threshold(tiny_config):
    frame = pd.concat(
        [
            make_experiments({"head": [0, 0, 5]}),
            make_experiments({"head": [0, 200, 2000]}, world="things-4"),
            make_experiments({"head": [9, 9]}, length=2),
        ],
        ignore_index=True,
    )
    scp = flatland_scp(frame, tiny_config)
    thresholds = [0.0, 1.0, 10.0, 100.0, 1000.0]
    rows = scp[["world", "threshold", "n", "commuted"]].values.tolist()
    assert rows == [
        *(["furnished", t, 3, k] for t, k in zip(thresholds, [2, 2, 3, 3, 3], strict=True)),
        *(["things-4", t, 3, k] for t, k in zip(thresholds, [1, 1, 1, 1, 2], strict=True)),
    ]
    assert scp["scp"].tolist() == (scp["commuted"] / scp["n"]).tolist()
    low, high = wilson_interval(scp["commuted"].to_numpy(), scp["n"].to_numpy())
    assert np.array_equal(scp["ci_low"], low) and np.array_equal(scp["ci_high"], high)


def test_sensitivity_compares_lengths_in_the_same_start_situations(tiny_config):
    frame = pd.concat(
        [
            make_experiments({"head": [0, 0, 0, 9, 9]}),  # five experiments, the others three
            make_experiments({"head": [0, 0, 9]}, length=6),
            make_experiments({"head": [0, 9, 9]}, length=2),
            make_experiments({"head": [7, 7, 7]}, world="things-4"),
        ],
        ignore_index=True,
    )
    table = flatland_sensitivity(frame, tiny_config)
    table = table[table["threshold"] == 0]
    assert table[["world", "length", "n", "commuted"]].values.tolist() == [
        ["furnished", 2, 3, 1], ["furnished", 4, 3, 3], ["furnished", 6, 3, 2]
    ]  # fmt: skip


# ---- comparisons ------------------------------------------------------------------------------


def test_comparisons_by_hand():
    """a always commutes, b in half of the situations, c in the other half."""
    table = compare_dofs(
        make_experiments({"a": [0] * 8, "b": [0] * 4 + [1] * 4, "c": [1] * 4 + [0] * 4})
    )
    assert table[["dof_a", "dof_b", "n", "only_a", "only_b", "difference"]].values.tolist() == [
        ["a", "b", 8, 4, 0, 0.5], ["a", "c", 8, 4, 0, 0.5], ["b", "c", 8, 4, 4, 0.0]
    ]  # fmt: skip
    assert table["p"].tolist() == pytest.approx([2 / 16, 2 / 16, 1.0])
    assert table["p_adjusted"].tolist() == pytest.approx([3 / 8, 3 / 8, 1.0])
    assert (table["ci_low"] < table["difference"]).all()
    assert (table["difference"] < table["ci_high"]).all()


def test_comparisons_pair_experiments_of_the_same_situation():
    frame = make_experiments({"a": [0, 1, 0, 1], "b": [0, 1, 0, 1]})
    shuffled = pd.concat([frame[:4], frame[4:].iloc[::-1]])
    assert compare_dofs(shuffled)[["only_a", "only_b"]].values.tolist() == [[0, 0]]
    frame = make_experiments({"a": [0, 5, 5], "b": [0, 0, 50]})
    for threshold, expected in ((0.0, [0, 1]), (10.0, [1, 0])):
        assert compare_dofs(frame, threshold)[["only_a", "only_b"]].values.tolist() == [expected]
    with pytest.raises(ValueError, match="same experiments"):
        compare_dofs(make_experiments({"a": [0, 0, 0], "b": [0, 0]}))


def test_comparisons_are_corrected_within_each_agent_and_world(tiny_config):
    two = {"a": [0] * 10, "b": [1] * 10}
    frame = pd.concat(
        [
            make_experiments(two),
            make_experiments({**two, "c": [0] * 10}, agent="slow-base"),
            make_experiments({"a": [1] * 10, "b": [1] * 10}, length=2),
        ],
        ignore_index=True,
    )
    table = flatland_comparisons(frame, tiny_config)
    assert table["agent"].tolist() == ["polyphemus"] + ["slow-base"] * 3
    p = 2 / 2**10
    assert table["p_adjusted"].tolist() == pytest.approx([p, 3 * p, 1.0, 3 * p])


# ---- trends -----------------------------------------------------------------------------------

WORLDS = ["things-0", "things-4", "things-8", "things-12"]
COUNTS = {
    ("polyphemus", "left-elbow"): [95, 90, 85, 80],
    ("long-arms", "left-elbow"): [90, 80, 70, 60],
    ("polyphemus", "head"): [100, 100, 100, 100],
    ("long-arms", "head"): [100, 100, 100, 100],
}


def make_scp(commuted: dict[tuple[str, str], list[int]], n: int = 100) -> pd.DataFrame:
    """A table flatland_scp; (agent, dof) -> how many of n commuted in each of WORLDS."""
    rows = [
        (world, agent, 4, dof, 0.0, n, k, k / n, 0.0, 1.0)
        for (agent, dof), counts in commuted.items()
        for world, k in zip(WORLDS, counts, strict=True)
    ]
    return pd.DataFrame(rows, columns=flatland_scp.column_names)


def test_trends_by_hand(tiny_config):
    trends = flatland_trends(make_scp(COUNTS), tiny_config)
    table = trends.set_index(["trend", "stratum", "dof"])
    assert len(table) == 2 * (2 + 1)
    elbow = table.loc[(OBJECTS, "polyphemus", "left-elbow")]
    assert elbow["effect"] == pytest.approx(-0.05 / 4)  # 5 % less with every four objects
    expected = cochran_armitage([95, 90, 85, 80], [100] * 4, [0, 4, 8, 12])
    assert (elbow["statistic"], elbow["p"]) == pytest.approx((expected.z, expected.p))
    longer = table.loc[(ARM_LENGTH, "all worlds", "left-elbow")]
    assert longer["effect"] == pytest.approx(np.mean([-0.05, -0.10, -0.15, -0.20]))
    arms = mantel_haenszel([90, 80, 70, 60], [100] * 4, [95, 90, 85, 80], [100] * 4)
    assert (longer["statistic"], longer["p"]) == pytest.approx((arms.odds_ratio, arms.p))
    assert longer["statistic"] < 1
    assert (table.xs("head", level="dof")["p"] == 1).all()
    assert table["p_adjusted"].tolist() == pytest.approx(holm(table["p"].to_numpy()).tolist())


def test_trends_use_the_rows_of_the_combinations_in_any_order(tiny_config):
    scp = make_scp(COUNTS)
    expected = flatland_trends(scp, tiny_config).reset_index(drop=True)
    backwards = pd.concat([group[::-1] for _, group in scp.groupby("dof", sort=False)])
    others = [
        scp.assign(threshold=10.0, commuted=0, scp=0.0),
        scp.assign(world="furnished", commuted=0, scp=0.0)[:1],
        scp.assign(agent="slow-base", commuted=0, scp=0.0),
    ]
    for frame in (backwards, pd.concat([scp, *others])):
        found = flatland_trends(frame, tiny_config).reset_index(drop=True)
        pd.testing.assert_frame_equal(found, expected)
    one_agent = update_flatland(tiny_config, combinations={"agents": ["polyphemus"]})
    assert set(flatland_trends(scp, one_agent)["trend"]) == {OBJECTS}


def test_the_odds_ratio_is_infinite_if_only_the_longer_arms_always_commute(tiny_config):
    always, sometimes = [100] * 4, [100, 99, 98, 97]
    for counts, infinite in (((sometimes, always), 1), ((always, sometimes), 0)):
        agents = zip(("polyphemus", "long-arms"), counts, strict=True)
        scp = make_scp({(agent, "head"): commuted for agent, commuted in agents})
        assert np.isinf(flatland_trends(scp, tiny_config)["statistic"]).sum() == infinite


# ---- commutation ------------------------------------------------------------------------------


def test_commutation_by_hand(tiny_config):
    rows = [
        ("furnished", "head", "head", 0, 0, 0.0),
        ("furnished", "head", "left-elbow", 0, 0, 0.0),
        ("settled", "head", "left-elbow", 0, 0, 0.0),
        ("furnished", "head", "head", 1, 1, 0.0),
        ("furnished", "head", "left-elbow", 1, 1, 7.0),
        ("settled", "head", "left-elbow", 1, 1, 0.0),
    ]
    frame = pd.DataFrame(rows, columns=flatland_commutation_experiments.column_names)
    table = flatland_commutation(frame, tiny_config)
    found = table.set_index(["world", "dof_a", "dof_b"])[["n", "commuted", "probability"]]
    assert {key: tuple(row) for key, row in zip(found.index, found.values, strict=True)} == {
        ("furnished", "head", "head"): (2, 2, 1.0),
        ("furnished", "head", "left-elbow"): (2, 1, 0.5),
        ("furnished", "left-elbow", "head"): (2, 1, 0.5),
        ("settled", "head", "left-elbow"): (2, 2, 1.0),
        ("settled", "left-elbow", "head"): (2, 2, 1.0),
    }
    low, high = wilson_interval(table["commuted"].to_numpy(), table["n"].to_numpy())
    assert np.allclose(table["ci_low"], low) and np.allclose(table["ci_high"], high)


# ---- alternatives to the SCP ------------------------------------------------------------------

EXCESS = [(k * 3) % 8 for k in range(8)]


def make_baselines() -> pd.DataFrame:
    """A table flatland_baselines: the naive change rises along DOFS, EXCESS does not."""
    rows = [
        (dof, float(k), 0.1, 10.0 + EXCESS[k], 0.1, np.nan, 100, 20) for k, dof in enumerate(DOFS)
    ]
    return pd.DataFrame(rows, columns=flatland_baselines.column_names)


def test_the_excess_error_is_above_the_smallest_of_all(tiny_config):
    frame = make_baselines()
    gathered = flatland_baselines.gather(frame)
    assert gathered["excess_error"].tolist() == EXCESS
    pd.testing.assert_frame_equal(gathered.drop(columns="excess_error"),
                                  frame.drop(columns="excess_error"))  # fmt: skip


def test_alternatives_are_correlated_with_one_minus_scp(tiny_config, monkeypatch):
    few = partial(ranks.rank_correlation, permutations=99)
    monkeypatch.setattr(ranks, "rank_correlation", few)
    baselines = make_baselines().assign(excess_error=EXCESS)

    def correlate(scp: list[float]) -> pd.DataFrame:
        rows = [("furnished", "polyphemus", 4, dof, 0.0, 100, 0, p, 0.0, 1.0)
                for dof, p in zip(DOFS, scp, strict=True)]  # fmt: skip
        table = pd.DataFrame(rows, columns=flatland_scp.column_names)
        others = [table.assign(scp=0.0, **{column: value}) for column, value in (
            ("threshold", 10.0), ("world", "things-4"), ("agent", "slow-base"))]  # fmt: skip
        scp_table = pd.concat([table, *others])[::-1]
        return flatland_alternatives(baselines, scp_table, tiny_config).set_index("alternative")

    table = correlate([1.0 - k / 10 for k in range(8)])  # the order of the naive change
    assert table.index.tolist() == ["naive change", "excess prediction error"]
    naive = table.loc["naive change"]
    assert naive[["n", "spearman", "kendall", "p"]].tolist() == pytest.approx([8, 1.0, 1.0, 0.01])
    squares = sum((k - EXCESS[k]) ** 2 for k in range(8))
    assert table.loc["excess prediction error", "spearman"] == pytest.approx(
        1 - 6 * squares / (8 * 63)
    )
    table = correlate([1.0] * 8)  # all SCPs equal: there is no order, as may be in a tiny run
    assert table["spearman"].isna().all() and (table["p"] == 1).all()
