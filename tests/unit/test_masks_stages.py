"""From scores and places to summaries, comparisons, discoveries, the map's measures and claims, on made-up data with known answers."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.simulated.object_experiments import COMPARISONS
from sensory_commutativity.storage.tables import TABLES
from sensory_commutativity.studies.loading import load
from sensory_commutativity.studies.objects.arrays.mask_examples import chosen_examples
from sensory_commutativity.studies.objects.claims import mask_claims
from sensory_commutativity.studies.objects.tables.local_scp_summary import area_under_curve
from sensory_commutativity.studies.objects.tables.local_scp_summary import summarised as map_summary
from sensory_commutativity.studies.objects.tables.mask_comparisons import compared
from sensory_commutativity.studies.objects.tables.mask_discoveries import discoveries
from sensory_commutativity.studies.objects.tables.mask_scores import first_of_each
from sensory_commutativity.studies.objects.tables.mask_summary import ious, summarised
from tests.helpers import DEFAULT

IDENTICAL, DIFFERENT, MOVED = range(3)


@pytest.fixture(scope="module")
def config():
    return load(DEFAULT)


def scores(
    model: str, test_set: str, right: dict[str, int], n: int = 20, iou: float = 0.9
) -> pd.DataFrame:
    """`n` tuples of each outcome; the first `right` of each are predicted right, the others as the next outcome; half the second masks are empty."""
    rows = []
    for k, outcome in enumerate(OUTCOMES):
        for i in range(n):
            said = outcome if i < right[outcome] else OUTCOMES[(k + 1) % 3]
            both = (
                (iou - 0.01 * (i % 3), iou if i % 2 else np.nan)
                if outcome == "moved"
                else (np.nan, np.nan)
            )
            rows.append(
                (model, test_set, i // 2, k * n + i, "random", outcome, said, *both, 90, 100, 95)
            )
    return pd.DataFrame(rows, columns=[column.name for column in TABLES["mask_scores"]])


ALL = dict.fromkeys(OUTCOMES, 20)


def test_a_summary_by_hand():
    found = summarised(
        scores("raft", "as-trained", {"identical": 20, "different": 10, "moved": 15}),
        np.random.default_rng(0),
    )
    assert found["accuracy"] == pytest.approx(0.75) and found["ci_low"] < 0.75 < found["ci_high"]
    assert (found["recall_identical"], found["recall_different"], found["recall_moved"]) == (
        1,
        0.5,
        0.75,
    )
    assert found["n"] == 60 and found["n_moved"] == 20 and found["pooled_iou"] == pytest.approx(0.9)
    table = scores("raft", "as-trained", ALL)
    assert (
        found["mean_iou"] == pytest.approx(np.nanmean(ious(table)))
        and found["iou_ci_low"] <= found["mean_iou"] <= found["iou_ci_high"]
    )


def test_an_empty_view_neither_helps_nor_harms():
    table = pd.DataFrame({"iou_1": [0.4, 0.4, np.nan], "iou_2": [0.8, np.nan, np.nan]})
    assert ious(table).tolist() == pytest.approx([0.6, 0.4, np.nan], nan_ok=True)


def test_the_first_tuples_of_each_outcome_count():
    outcomes = [
        np.array([MOVED, IDENTICAL, MOVED, DIFFERENT]),
        np.array([IDENTICAL, MOVED, IDENTICAL, DIFFERENT]),
        np.array([MOVED, IDENTICAL]),
    ]
    assert [places.tolist() for places in first_of_each(outcomes, 2)] == [[0, 1, 2, 3], [0, 3], []]
    assert [places.tolist() for places in first_of_each(outcomes, 9)] == [
        [0, 1, 2, 3],
        [0, 1, 2, 3],
        [0, 1],
    ]


def test_models_are_compared_on_the_same_tuples():
    table = pd.concat(
        [
            scores("raft", "as-trained", ALL),
            scores("flownet", "as-trained", {**ALL, "moved": 5}, iou=0.5),
        ],
        ignore_index=True,
    )
    found = compared(table).set_index("measure")
    assert found.loc["accuracy", "difference"] == pytest.approx(15 / 60) and found.loc[
        "accuracy", "p_tuples"
    ] == pytest.approx(2 * 0.5**15)
    by_household = [
        0,
        0,
        0.5,
        *[1] * 7,
    ]  # of the difference of the two tuples of each household in which something moved
    assert found.loc["accuracy", "households"] == 10 and found.loc[
        "accuracy", "p"
    ] == pytest.approx(stats.ttest_1samp(by_household, 0).pvalue)
    assert (
        found.loc["iou", "difference"] == pytest.approx(0.4)
        and found.loc["iou", "p_tuples"] < 0.001
    )
    with pytest.raises(ValueError, match="same tuples"):
        compared(table[~((table["model"] == "flownet") & (table["experiment"] == 3))])


def alternatives(
    outcome: np.ndarray, truth: np.ndarray, overlap: np.ndarray, touched: np.ndarray
) -> pd.DataFrame:
    """The table mask_alternatives of arrays (n, 3): a column per comparison."""
    n, names = len(truth), np.array(OUTCOMES)
    both = dict(
        household=np.arange(n) // 2,
        experiment=range(n),
        touched=touched.any(1),
        touched_first=touched[:, 1],
    )
    frames = [
        pd.DataFrame(
            dict(
                **both,
                comparison=comparison,
                outcome_true=names[truth[:, k]],
                outcome_predicted=names[outcome[:, k]],
                overlap=overlap[:, k],
            )
        )
        for k, comparison in enumerate(COMPARISONS)
    ]
    return pd.concat(frames, ignore_index=True)


def test_discoveries_by_hand():
    """Ten experiments; something moved in four; both orders show three of them, first against last none, a return three; two touched a wall."""
    truth = np.full((10, 3), IDENTICAL)
    truth[:4, 0], truth[:, 1], truth[:4, 2] = MOVED, DIFFERENT, MOVED
    outcome = truth.copy()
    outcome[3, 0] = IDENTICAL
    outcome[9, 0] = MOVED  # a false alarm
    outcome[8, 0] = DIFFERENT
    overlap = np.full((10, 3), 0.8)
    overlap[2, 2] = 0.4
    touched = np.zeros((10, 3), bool)
    touched[7:9] = True
    table = alternatives(outcome, truth, overlap, touched)
    found = discoveries(table.sample(frac=1, random_state=0), np.random.default_rng(0)).set_index(
        "comparison"
    )  # in whatever order rows come
    assert found["discovered"].tolist() == [3, 0, 3] and found["per_hundred"].tolist() == [
        30,
        0,
        30,
    ]
    assert found["false_alarms"].tolist() == [1, 0, 0] and found.loc[
        "first-last", "p_experiments"
    ] == pytest.approx(0.25)
    of_households = [
        -100,
        -50,
        0,
        0,
        0,
    ]  # what first against last finds less of, in those with two experiments each
    assert (
        found.loc["first-last", "p"] == pytest.approx(stats.ttest_1samp(of_households, 0).pvalue)
        and found.loc["first-last", "difference"] == -30
    )
    assert found["hits"].tolist() == [0.5, 1, 0] and found["false_hits"].tolist() == [0, 1, 0]
    assert found["hits_difference"].tolist() == [0, 0.5, -0.5] and found["n_touched"].tolist() == [
        2,
        2,
        2,
    ]
    assert (found["ci_low"] <= found["per_hundred"]).all() and (
        found["per_hundred"] <= found["ci_high"]
    ).all()


def test_touching_in_the_second_order_alone_is_neither_a_hit_nor_a_false_one():
    outcome = np.full((4, 3), DIFFERENT)
    touched = np.zeros((4, 3), bool)
    touched[0, 0] = True  # in the second order
    touched[1] = True
    found = discoveries(
        alternatives(outcome, outcome, np.zeros((4, 3)), touched), np.random.default_rng(0)
    )
    assert (found["n_touched"] == 1).all() and (found["n_untouched"] == 2).all()


def test_examples_are_chosen_by_rank():
    table = scores("raft", "as-trained", ALL)
    table.loc[table["outcome_true"] == "moved", "iou_1"] = np.linspace(0, 1, 20)
    table["iou_2"] = np.nan
    shown = chosen_examples(table)
    assert [experiment for experiment, _ in shown] == [42, 50, 57, 0, 20]
    assert [overlap for _, overlap in shown[:3]] == pytest.approx([2 / 19, 10 / 19, 17 / 19])


# ---- the map -----------------------------------------------------------------------------------------------------------------


def test_the_area_under_the_curve_by_hand():
    scp, within = np.array([0.1, 0.2, 0.5, 0.9]), np.array([True, True, False, False])
    assert area_under_curve(scp, within) == 1 and area_under_curve(1 - scp, within) == 0
    assert area_under_curve(np.array([0.1, 0.5, 0.5, 0.9]), within) == 0.875
    assert np.isnan(area_under_curve(scp, np.ones(4, bool)))


@pytest.fixture(scope="module")
def places():
    """Forty places: near things the local SCP is low, and so it is in the kitchen."""
    rng, rows = np.random.default_rng(0), []
    for i in range(40):
        near = i % 2 == 0
        scp = (0.2 if near else 0.95) + rng.uniform(-0.05, 0.05)
        room = "kitchen" if near else "living"
        rows.append(
            (
                "rs",
                "shoulder-pan",
                room,
                i / 2,
                0.0,
                0.0,
                10,
                5,
                scp,
                0.0,
                1.0,
                scp,
                -0.1 if near else 0.5,
                near,
                "wall" if near else "",
                i % 8 == 1,
            )
        )
    return pd.DataFrame(rows, columns=[column.name for column in TABLES["local_scp"]])


def test_the_map_s_measures(places, config):
    found = map_summary(places, config).set_index(["decided_by", "where"])
    assert found.loc[("predictor", "all"), "estimate"] == 1
    assert (
        found.loc[("predictor", "open"), "estimate"] > 0.9
        and found.loc[("simulator", "kitchen"), "estimate"] < 0.3
    )
    assert found.loc[("predictor", "over low things"), "n"] == 5
    assert (found["ci_low"] <= found["estimate"]).all() and (
        found["estimate"] <= found["ci_high"]
    ).all()


def claims(
    config, places, raft: pd.DataFrame, other: pd.DataFrame, found: pd.DataFrame
) -> dict[str, bool]:
    parts = {"as-trained": raft, "all-other": other}
    rng = np.random.default_rng(0)
    summary = pd.DataFrame(
        [dict(model="raft", test_set=name, **summarised(part, rng)) for name, part in parts.items()]
    )
    comparisons = compared(
        pd.concat(
            [raft, scores("flownet", "as-trained", dict.fromkeys(OUTCOMES, 0), iou=0.5)],
            ignore_index=True,
        )
    )
    tables = dict(
        mask_summary=summary,
        mask_comparisons=comparisons,
        mask_discoveries=found,
        local_scp_summary=map_summary(places, config),
    )
    return {claim.claim: bool(claim.holds) for claim in mask_claims(tables, config)}


def made_up_discoveries(blind: bool) -> pd.DataFrame:
    n = 300
    truth = np.full((n, 3), IDENTICAL)
    truth[:60, 0], truth[:, 1], truth[:60, 2] = MOVED, DIFFERENT, MOVED
    outcome, touched = truth.copy(), np.zeros((n, 3), bool)
    touched[100:200] = True
    outcome[100:180, 0] = DIFFERENT
    if not blind:
        outcome[100:180, 2] = DIFFERENT
    return discoveries(
        alternatives(outcome, truth, np.full((n, 3), 0.9), touched), np.random.default_rng(0)
    ).assign(kind="random")


def test_all_claims_hold_where_all_is_as_the_paper_says(config, places):
    found = claims(
        config,
        places,
        scores("raft", "as-trained", ALL),
        scores("raft", "all-other", ALL),
        made_up_discoveries(True),
    )
    assert len(found) == 8 and all(found.values()), found


def test_claims_fail_where_they_do_not_hold(config, places):
    spoilt = places.assign(scp=0.6)
    weak = scores("raft", "as-trained", dict.fromkeys(OUTCOMES, 12), iou=0.5)
    found = claims(
        config, spoilt, weak, scores("raft", "all-other", ALL, iou=0.7), made_up_discoveries(False)
    )
    assert [claim for claim, holds in found.items() if holds] == [
        "first against last picture finds fewer moved objects than SC-experiments"
    ]
