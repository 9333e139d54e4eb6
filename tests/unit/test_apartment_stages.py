"""From SC-experiments in apartments to SCP, hierarchy, stability of the order, true interaction and claims, on made-up experiments."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from tests.helpers import DEFAULT

from sensory_commutativity.storage.tables import TABLES, read_table, write_table
from sensory_commutativity.studies.apartment.claims import apartment_claims
from sensory_commutativity.studies.apartment.tables.apartment_hierarchy import (
    group_steps,
    paired_means,
    write_hierarchy,
)
from sensory_commutativity.studies.apartment.tables.apartment_interaction import interactions
from sensory_commutativity.studies.apartment.tables.apartment_order import compare_orders_of_dofs
from sensory_commutativity.studies.apartment.tables.apartment_scp import write_scp
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.apartment.robots.robot import load_robot

N = 40
SCP = {
    "fetch": dict(zip(
        ["right-wheel", "left-wheel", "torso-lift", "shoulder-pan", "shoulder-lift", "upperarm-roll", "elbow-flex", "forearm-roll", "wrist-flex",
         "wrist-roll"], [0.2, 0.2, 1.0, 0.5, 0.5, 0.7, 0.75, 0.9, 0.9, 0.95], strict=True)),
    "jackrabbot": None,
}  # fmt: skip


@pytest.fixture(scope="module")
def config() -> Config:
    return load(DEFAULT)


def made_up(config: Config, scp: dict[str, dict[str, float]]) -> pd.DataFrame:
    """Every run of the configuration, with N experiments; a fraction of each degree of freedom's experiments commutes at every threshold, all
    in free space."""
    rows = []
    for run in config.apartment.runs():
        for d, (dof, value) in enumerate(scp[run.robot].items()):
            for i in range(N):
                commutes = run.scene == "free-space" or (i * 7 + d) % N < round(value * N)
                for view in config.apartment.fields_of_view:
                    touched = 0 if commutes else 3
                    rows.append(
                        (
                            *run[:4],
                            dof,
                            i,
                            1,
                            view,
                            touched,
                            0,
                            0,
                            0,
                            0.0,
                            0.0,
                            0.0,
                            0.0,
                            0.1,
                            5.0 if commutes else 900.0,
                        )
                    )
    return pd.DataFrame(rows, columns=[column.name for column in TABLES["apartment_experiments"]])


@pytest.fixture(scope="module")
def scp(config) -> dict[str, dict[str, float]]:
    jackrabbot = load_robot(config.apartment.robots["jackrabbot"].description)
    groups = {dof: i for i, dofs in enumerate(jackrabbot.hierarchy.values()) for dof in dofs}
    return {**SCP, "jackrabbot": {dof: 0.2 + 0.2 * i for dof, i in groups.items()}}


@pytest.fixture(scope="module")
def experiments(config, scp) -> pd.DataFrame:
    return made_up(config, scp)


@pytest.fixture
def file(experiments, config, tmp_path):
    write_table("apartment_experiments", experiments, tmp_path / "e.parquet", config)
    return tmp_path / "e.parquet"


def test_the_scp_is_counted_at_every_threshold(file, config, scp, tmp_path):
    write_scp(file, tmp_path / "scp.parquet", config)
    table = read_table("apartment_scp", tmp_path / "scp.parquet")
    assert (
        len(table)
        == sum(len(scp[run.robot]) for run in config.apartment.runs())
        * len(config.apartment.thresholds)
        * 2
    )
    zero = table[(table["threshold"] == 0) & (table["robot"] == "fetch")]
    assert (zero["scp"] == 0).all()
    for row in table[(table["threshold"] == 50) & (table["robot"] == "fetch")].itertuples():
        expected = 1.0 if row.apartment == "free-space" else scp["fetch"][row.dof]
        assert (
            row.n == N
            and row.scp == pytest.approx(expected, abs=1 / N)
            and row.ci_low <= row.scp <= row.ci_high
        )


def test_steps_of_the_hierarchy_by_hand():
    distance = {"a": [900, 900, 900, 5], "b": [900, 5, 900, 5], "c": [5, 5, 5, 900]}
    frame = pd.DataFrame(
        [(dof, i, float(d)) for dof, ds in distance.items() for i, d in enumerate(ds)],
        columns=["dof", "experiment", "distance"],
    )
    table = group_steps(frame, {"low_furniture": ["a", "b"], "high": ["c"]}, 50)
    expected = np.array([0 - 1, 0.5 - 1, 0 - 1, 1 - 0])
    assert table[["lower", "higher", "n"]].values.tolist() == [["low", "high", 4]]
    row = table.iloc[0]
    assert (row["scp_lower"], row["scp_higher"], row["difference"]) == pytest.approx(
        (3 / 8, 3 / 4, expected.mean())
    )
    assert (
        row["p"] == pytest.approx(stats.ttest_1samp(expected, 0).pvalue)
        and row["ci_low"] < row["difference"] < row["ci_high"]
    )


def test_equal_differences_are_judged_by_their_signs():
    assert paired_means(np.zeros(5)) == (0, 0, 1)
    low, high, p = paired_means(np.full(5, -0.5))
    assert (low, p) == (-0.5, 2 * 0.5**5) and -0.5 < high < 0.5
    assert paired_means(np.full(100, 1.0))[0] == pytest.approx(
        1 - 2 * 0.0362, abs=1e-3
    )  # Clopper-Pearson: up to 3.6 % of a hundred


def test_the_hierarchy_of_both_robots_is_written(file, config, tmp_path):
    write_hierarchy(file, tmp_path / "h.parquet", config)
    table = read_table("apartment_hierarchy", tmp_path / "h.parquet")
    fetch = table[
        (table["robot"] == "fetch")
        & (table["threshold"] == 50)
        & (table["start"] == "anywhere")
        & (table["length"] == 50)
    ]
    steps = fetch[(fetch["apartment"] == "rs-stand-in") & (fetch["field_of_view"] == 90)]
    assert steps[["lower", "higher"]].values.tolist() == [
        ["wheel", "shoulder"],
        ["shoulder", "elbow"],
        ["elbow", "wrist"],
    ]
    assert (steps["difference"] < 0).all() and (steps["p_adjusted"] >= steps["p"]).all()
    assert {"fetch", "jackrabbot"} == set(table["robot"])


def test_the_same_order_has_tau_one_and_every_change_is_there(experiments, config):
    table = compare_orders_of_dofs(experiments, config)
    changed = table.groupby("changed").size().to_dict()
    assert changed == {"threshold": 5, "field of view": 1, "apartment": 2, "start": 1, "length": 2}
    assert table.loc[table["value"].isin(["20", "100", "200"]), "tau"].tolist() == pytest.approx(
        [1, 1, 1]
    )
    assert np.isnan(
        table.loc[table["value"] == "0", "tau"]
    ).all()  # nothing commutes at 0 here: no order
    assert (table.loc[table["changed"] != "threshold", "tau"] > 0.99).all() and (
        table["n"] == N
    ).all()


def test_true_interaction_is_split_into_three(experiments, config):
    frame = experiments.copy()
    half = frame["experiment"] < N // 2
    frame["touched_fixed"] = np.where(half, 2, 0)
    frame["at_limit"] = np.where(frame["experiment"] % 2 == 0, 1, 0)
    table = interactions(frame, 50, 90.0)
    assert (table["touched"] == 0.5).all() and (table["n_touched"] == N // 2).all()
    assert (table["n_hindered"] == N // 4).all() and (table["n_free"] == N // 4).all()
    commuted = table[["commuted_touched", "commuted_hindered", "commuted_free"]].sum(axis=1)
    assert (commuted == (table["scp"] * N).round()).all()


def claims(experiments, config, tmp_path) -> dict[str, bool]:
    write_table("apartment_experiments", experiments, tmp_path / "e.parquet", config)
    write_scp(tmp_path / "e.parquet", tmp_path / "scp.parquet", config)
    write_hierarchy(tmp_path / "e.parquet", tmp_path / "h.parquet", config)
    tables = dict(
        apartment_scp=read_table("apartment_scp", tmp_path / "scp.parquet"),
        apartment_hierarchy=read_table("apartment_hierarchy", tmp_path / "h.parquet"),
        apartment_order=compare_orders_of_dofs(experiments, config),
    )
    return {claim.claim: claim.holds for claim in apartment_claims(tables, config)}


def test_all_claims_hold_where_all_is_as_the_paper_says(experiments, config, tmp_path):
    found = claims(experiments, config, tmp_path)
    assert len(found) == 9 and all(found.values()), found


@pytest.mark.parametrize(
    ("dof", "value", "fails"),
    [
        ("left-wheel", 0.6, "fetch: the wheels have the lowest SCP"),
        ("torso-lift", 0.9, "fetch: torso-lift always commutes"),
        ("shoulder-pan", 0.8, "fetch: the arm joint nearest the body has the SCP nearest .5"),
        ("wrist-roll", 0.3, "fetch: the SCP rises along wheel < shoulder < elbow < wrist"),
    ],
)
def test_a_claim_fails_where_it_does_not_hold(dof, value, fails, scp, config, tmp_path):
    changed = {**scp, "fetch": {**scp["fetch"], dof: value}}
    found = claims(made_up(config, changed), config, tmp_path)
    assert not found[fails] and found["jackrabbot: the wheels have the lowest SCP"]


def test_free_space_that_does_not_commute_is_told(experiments, config, tmp_path):
    spoilt = experiments.copy()
    spoilt.loc[
        (spoilt["apartment"] == "free-space")
        & (spoilt["robot"] == "fetch")
        & (spoilt["experiment"] == 0),
        "distance",
    ] = 900.0
    found = claims(spoilt, config, tmp_path)
    assert (
        not found["fetch: in free space everything commutes"]
        and found["jackrabbot: in free space everything commutes"]
    )


def test_a_robot_without_a_hierarchy_has_a_table_without_rows_and_no_such_claim(tmp_path, config):
    """As the smallest description in config/robots/README.md: an arm that is fixed to the floor, and nothing expected of it."""
    from tests.worlds.apartment.examples import write_robot

    from sensory_commutativity.studies.loading import merge, validate

    write_robot(tmp_path, {"start": {"turn": [-0.5, 0.5]}})
    mine = {
        "robots": {"mine": {"description": str(tmp_path / "mine.yaml")}},
        "reference": {"robot": "mine"},
        "robots_compared": {"robots": []},
    }
    mine |= {
        "scenes_compared": {"robots": ["mine"]},
        "within_reach": {"robots": ["mine"]},
        "free_space": {"robots": ["mine"]},
    }
    config = validate(
        merge(
            config.model_dump(mode="json"),
            {"apartment": mine, "masks": {"robot": "mine", "fixed": {}}},
        )
    )
    dofs = [dof.name for dof in load_robot(tmp_path / "mine.yaml").dofs]
    found = claims(made_up(config, {"mine": dict.fromkeys(dofs, 0.5)}), config, tmp_path)
    assert read_table("apartment_hierarchy", tmp_path / "h.parquet").empty
    assert (
        not any("rises" in claim or "wheels" in claim for claim in found)
        and found["mine: in free space everything commutes"]
    )
