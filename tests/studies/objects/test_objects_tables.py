"""From scores and poses to summaries, comparisons and discoveries; answers by hand."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.simulated.object_experiments import COMPARISONS, KINDS
from sensory_commutativity.studies.objects.arrays.mask_examples import choose_examples
from sensory_commutativity.studies.objects.claims import mask_claims
from sensory_commutativity.studies.objects.tables import local_scp_summary as map_module
from sensory_commutativity.studies.objects.tables import mask_discoveries as discoveries_module
from sensory_commutativity.studies.objects.tables import mask_summary as summary_module
from sensory_commutativity.studies.objects.tables.local_scp import local_scp
from sensory_commutativity.studies.objects.tables.local_scp_summary import local_scp_summary
from sensory_commutativity.studies.objects.tables.mask_comparisons import compare_models
from sensory_commutativity.studies.objects.tables.mask_discoveries import (
    mask_discoveries,
    summarize_comparisons,
)
from sensory_commutativity.studies.objects.tables.mask_scores import first_of_each_outcome
from sensory_commutativity.studies.objects.tables.mask_summary import (
    mean_iou_per_tuple,
    summarize_scores,
)
from tests.studies.objects.examples import ALL, DIFFERENT, IDENTICAL, MOVED, make_scores


@pytest.fixture(autouse=True)
def few_resamples(monkeypatch):
    """Fewer resamples of the bootstrap than in studies, which take seconds."""
    for module in (map_module, discoveries_module, summary_module):
        monkeypatch.setattr(module, "RESAMPLES", 200)


# ---- scores -----------------------------------------------------------------------------------


def test_names_of_outcomes_and_comparisons_are_those_of_the_library():
    """Repeated in the tables, so that reading them imports no torch and no PyBullet."""
    assert summary_module.OUTCOMES == OUTCOMES
    assert discoveries_module.COMPARISONS == COMPARISONS and discoveries_module.KINDS == KINDS


def test_a_summary_by_hand():
    scores = make_scores("raft", "as-trained", {"identical": 20, "different": 10, "moved": 15})
    row = summarize_scores(scores, np.random.default_rng(0))
    assert row["accuracy"] == pytest.approx(0.75) and row["ci_low"] < 0.75 < row["ci_high"]
    recalls = [row[f"recall_{outcome}"] for outcome in OUTCOMES]
    assert recalls == [1, 0.5, 0.75]
    assert (row["n"], row["n_moved"], row["pooled_iou"]) == (60, 20, pytest.approx(0.9))
    moved = scores[scores["outcome_true"] == "moved"]
    overlap = [(0.9 - 0.01 * (i % 3) + 0.9) / 2 if i % 2 else 0.9 - 0.01 * (i % 3)
               for i in range(20)]  # fmt: skip
    assert mean_iou_per_tuple(moved).tolist() == pytest.approx(overlap)
    assert row["mean_iou"] == pytest.approx(np.mean(overlap))
    assert row["median_iou"] == pytest.approx(np.median(overlap))
    assert row["iou_ci_low"] <= row["mean_iou"] <= row["iou_ci_high"]


def test_an_empty_mask_is_left_out_of_the_mean_of_both():
    scores = pd.DataFrame({"iou_1": [0.4, 0.4, np.nan], "iou_2": [0.8, np.nan, np.nan]})
    assert mean_iou_per_tuple(scores).tolist() == pytest.approx([0.6, 0.4, np.nan], nan_ok=True)


def test_the_first_tuples_of_each_outcome_are_chosen_over_all_files():
    outcomes = [
        np.array([MOVED, IDENTICAL, MOVED, DIFFERENT]),
        np.array([IDENTICAL, MOVED, IDENTICAL, DIFFERENT]),
        np.array([MOVED, IDENTICAL]),
    ]
    for n, expected in (
        (2, [[0, 1, 2, 3], [0, 3], []]),
        (9, [[0, 1, 2, 3], [0, 1, 2, 3], [0, 1]]),
    ):
        chosen = first_of_each_outcome(outcomes, n)
        assert [rows.tolist() for rows in chosen] == expected


def test_models_are_compared_on_the_same_tuples():
    worse = make_scores("flownet", "as-trained", {**ALL, "moved": 5}, iou=0.5)
    scores = pd.concat([make_scores("raft", "as-trained", ALL), worse], ignore_index=True)
    table = compare_models(scores).set_index("measure")
    accuracy, overlap = table.loc["accuracy"], table.loc["iou"]
    assert accuracy["difference"] == pytest.approx(15 / 60)
    assert accuracy["p_tuples"] == pytest.approx(2 * 0.5**15)
    of_scenes = [0, 0, 0.5, *[1] * 7]  # difference of the tuples with a moved object, two a scene
    assert accuracy["households"] == 10
    assert accuracy["p"] == pytest.approx(stats.ttest_1samp(of_scenes, 0).pvalue)
    assert overlap["difference"] == pytest.approx(0.4) and overlap["p_tuples"] < 0.001
    missing = (scores["model"] == "flownet") & (scores["experiment"] == 3)
    with pytest.raises(ValueError, match="same tuples"):
        compare_models(scores[~missing])


def test_examples_are_chosen_by_the_rank_of_their_overlap():
    scores = make_scores("raft", "as-trained", ALL)
    scores.loc[scores["outcome_true"] == "moved", "iou_1"] = np.linspace(0, 1, 20)
    scores["iou_2"] = np.nan
    examples = choose_examples(scores)
    assert [experiment for experiment, _ in examples] == [42, 50, 57, 0, 20]
    assert [overlap for _, overlap in examples[:3]] == pytest.approx([2 / 19, 10 / 19, 17 / 19])


# ---- discoveries ------------------------------------------------------------------------------


def make_alternatives(
    predicted: np.ndarray, truth: np.ndarray, overlap: np.ndarray, touched: np.ndarray
) -> pd.DataFrame:
    """Rows of mask_alternatives from arrays (n, 3), a column for each comparison.

    `touched` is bool (n, 2): in the second order, in the first.
    """
    n, names = len(truth), np.array(OUTCOMES)
    shared = dict(household=np.arange(n) // 2, experiment=range(n), touched=touched.any(1),
                  touched_first=touched[:, 1])  # fmt: skip
    frames = [
        pd.DataFrame(dict(**shared, comparison=name, outcome_true=names[truth[:, k]],
                          outcome_predicted=names[predicted[:, k]], overlap=overlap[:, k]))
        for k, name in enumerate(COMPARISONS)
    ]  # fmt: skip
    return pd.concat(frames, ignore_index=True)


def test_discoveries_by_hand():
    """Ten experiments.

    In four something moved: both orders show three of them, first against last none, a return
    three, one of them in the wrong place. Two touched a wall.
    """
    truth = np.full((10, 3), IDENTICAL)
    truth[:4, 0], truth[:, 1], truth[:4, 2] = MOVED, DIFFERENT, MOVED
    predicted = truth.copy()
    predicted[3, 0] = IDENTICAL
    predicted[9, 0] = MOVED  # a false alarm
    predicted[8, 0] = DIFFERENT
    overlap = np.full((10, 3), 0.8)
    overlap[2, 2] = 0.4
    touched = np.zeros((10, 2), bool)
    touched[7:9] = True
    rows = make_alternatives(predicted, truth, overlap, touched)
    shuffled = rows.sample(frac=1, random_state=0)
    table = summarize_comparisons(shuffled, np.random.default_rng(0)).set_index("comparison")
    assert table["discovered"].tolist() == [3, 0, 3]
    assert table["discovery_rate"].tolist() == [30, 0, 30]
    assert table["false_alarms"].tolist() == [1, 0, 0]
    first_last = table.loc["first-last"]
    assert first_last["p_experiments"] == pytest.approx(0.25)
    assert first_last["difference"] == -30
    of_scenes = [-100, -50, 0, 0, 0]  # differences in the five scenes of two experiments each
    assert first_last["p"] == pytest.approx(stats.ttest_1samp(of_scenes, 0).pvalue)
    assert table["tpr"].tolist() == [0.5, 1, 0] and table["fpr"].tolist() == [0, 1, 0]
    assert table["tpr_difference"].tolist() == [0, 0.5, -0.5]
    assert table["n_touched"].tolist() == [2, 2, 2]
    for value, low, high in (("discovery_rate", "ci_low", "ci_high"),
                             ("tpr", "tpr_low", "tpr_high"),
                             ("fpr", "fpr_low", "fpr_high")):  # fmt: skip
        assert (table[low] <= table[value]).all() and (table[value] <= table[high]).all()


def test_experiments_that_touch_in_the_second_order_alone_count_as_neither():
    different = np.full((4, 3), DIFFERENT)
    touched = np.zeros((4, 2), bool)
    touched[0, 0] = True  # in the second order
    touched[1] = True
    rows = make_alternatives(different, different, np.zeros((4, 3)), touched)
    table = summarize_comparisons(rows, np.random.default_rng(0))
    assert (table["n_touched"] == 1).all() and (table["n_untouched"] == 2).all()


def test_kinds_of_sequences_are_summarized_separately(default_config):
    different, touched = np.full((8, 3), DIFFERENT), np.zeros((8, 2), bool)
    rows = make_alternatives(different, different, np.zeros((8, 3)), touched)
    kinds = rows["experiment"].map(lambda i: KINDS[i > 4])
    table = mask_discoveries(rows.assign(kind=kinds), default_config)
    assert table["kind"].tolist() == [KINDS[0]] * 3 + [KINDS[1]] * 3
    assert table["n"].tolist() == [5] * 3 + [3] * 3
    assert set(mask_discoveries(rows.assign(kind="random"), default_config)["kind"]) == {"random"}


# ---- the map ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def poses() -> pd.DataFrame:
    """A table local_scp of forty poses; the local SCP is low near walls and in the kitchen."""
    rng, rows = np.random.default_rng(0), []
    for i in range(40):
        near = i % 2 == 0
        scp = (0.2 if near else 0.95) + rng.uniform(-0.05, 0.05)
        rows.append(("rs", "shoulder-pan", "kitchen" if near else "living", i / 2, 0.0, 0.0, 10, 5,
                     scp, 0.0, 1.0, scp, -0.1 if near else 0.5, near, "wall" if near else "",
                     i % 8 == 1))  # fmt: skip
    return pd.DataFrame(rows, columns=local_scp.column_names)


def test_the_map_is_summarized_by_region(poses, default_config):
    table = local_scp_summary(poses, default_config)
    table = table.set_index(["decided_by", "where"])
    assert table.loc[("predictor", "all"), "estimate"] == 1
    assert table.loc[("predictor", "open"), "estimate"] > 0.9
    assert table.loc[("simulator", "kitchen"), "estimate"] < 0.3
    assert table.loc[("predictor", "over low things"), "n"] == 5
    assert (table["ci_low"] <= table["estimate"]).all()
    assert (table["estimate"] <= table["ci_high"]).all()
    nowhere = poses.assign(over_low=False, within_reach=False)  # neither measure is defined
    table = local_scp_summary(nowhere, default_config).set_index(["decided_by", "where"])
    assert table.loc[("predictor", "over low things"), "n"] == 0
    assert table.loc[("predictor", ["over low things", "all"]), "estimate"].isna().all()


# ---- claims -----------------------------------------------------------------------------------


def make_discoveries(blind: bool) -> pd.DataFrame:
    """Table mask_discoveries; a return shows no immovable object if it is `blind`."""
    n = 300
    truth = np.full((n, 3), IDENTICAL)
    truth[:60, 0], truth[:, 1], truth[:60, 2] = MOVED, DIFFERENT, MOVED
    predicted, touched = truth.copy(), np.zeros((n, 2), bool)
    touched[100:200] = True
    predicted[100:180, 0] = DIFFERENT
    if not blind:
        predicted[100:180, 2] = DIFFERENT
    rows = make_alternatives(predicted, truth, np.full((n, 3), 0.9), touched)
    return summarize_comparisons(rows, np.random.default_rng(0)).assign(kind="random")


def decide(
    config, poses: pd.DataFrame, as_trained: pd.DataFrame, other: pd.DataFrame, blind: bool
) -> dict[str, bool]:
    """Claim -> whether it holds."""
    rng = np.random.default_rng(0)
    rows = [dict(model="raft", test_set=name, **summarize_scores(scores, rng))
            for name, scores in (("as-trained", as_trained), ("all-other", other))]  # fmt: skip
    flownet = make_scores("flownet", "as-trained", dict.fromkeys(OUTCOMES, 0), iou=0.5)
    tables = dict(
        mask_summary=pd.DataFrame(rows),
        mask_comparisons=compare_models(pd.concat([as_trained, flownet], ignore_index=True)),
        mask_discoveries=make_discoveries(blind),
        local_scp_summary=local_scp_summary(poses, config),
    )
    return {claim.claim: bool(claim.holds) for claim in mask_claims(tables, config)}


def test_claims_hold_and_fail_as_their_rules_say(poses, default_config):
    good = make_scores("raft", "as-trained", ALL), make_scores("raft", "all-other", ALL)
    claims = decide(default_config, poses, *good, blind=True)
    assert len(claims) == 8 and all(claims.values()), claims
    weak = make_scores("raft", "as-trained", dict.fromkeys(OUTCOMES, 12), iou=0.5)
    other = make_scores("raft", "all-other", ALL, iou=0.7)
    claims = decide(default_config, poses.assign(scp=0.6), weak, other, blind=False)
    assert [claim for claim, holds in claims.items() if holds] == [
        "first against last picture finds fewer moved objects than SC-experiments"
    ]
    claims = decide(default_config, poses, *good, blind=False)
    assert [claim for claim, holds in claims.items() if not holds] == [
        "going back to the start does not show immovable things"
    ]
