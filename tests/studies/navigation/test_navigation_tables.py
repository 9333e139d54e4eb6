"""The tables computed from scores, against numbers computed in another way."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from statsmodels.duration.survfunc import survdiff
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.power import TTestIndPower

from sensory_commutativity.errors import TableError
from sensory_commutativity.statistics.groups import games_howell
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.declarations import Table
from sensory_commutativity.studies.navigation.tables import navigation_comparisons as module
from sensory_commutativity.studies.navigation.tables.navigation_calibration import (
    CALIBRATED,
    navigation_calibration,
)
from sensory_commutativity.studies.navigation.tables.navigation_checkpoints import (
    navigation_checkpoints,
)
from sensory_commutativity.studies.navigation.tables.navigation_comparisons import (
    CROSS_CHECKED,
    HALF,
    HOWELL,
    LOG_RANK,
    MANN_WHITNEY,
    PERMUTATION,
    RANKS,
    WELCH,
    compare_steps,
    navigation_comparisons,
    pairs,
)
from sensory_commutativity.studies.navigation.tables.navigation_power import (
    DETECTABLE,
    EFFECTS,
    NEEDED,
    POWER_AT,
    navigation_power,
)
from sensory_commutativity.studies.navigation.tables.navigation_profiles import navigation_profiles
from sensory_commutativity.studies.navigation.tables.navigation_scores import (
    MEASURES,
    STEPS,
    navigation_scores,
)
from sensory_commutativity.studies.navigation.tables.navigation_summary import navigation_summary
from sensory_commutativity.studies.navigation.tables.navigation_survival import navigation_survival
from tests.studies.navigation.examples import (
    ALPHA,
    CHECKPOINTS,
    SEEDS,
    SPACES,
    STEP,
    make_curves,
    with_spaces,
)

PAPER_PAIRS = [("truncated", "adapted"), ("truncated", "full"), ("adapted", "full")]
FROM_SCORES = (navigation_summary, navigation_comparisons, navigation_survival,
               navigation_profiles, navigation_power, navigation_calibration)  # fmt: skip


def check(frame: pd.DataFrame, table: Table, config) -> None:
    """Columns, unique keys and completeness."""
    assert set(table.column_names) <= set(frame)
    assert not frame.duplicated(table.key).any()
    runner.check_complete(frame, table, config, Path("table"))


def values(scores: pd.DataFrame, space: str, measure: str = STEPS) -> np.ndarray:
    return scores.loc[scores["action_space"] == space, measure].to_numpy()


@pytest.fixture(scope="module")
def comparisons(scores, five_spaces) -> pd.DataFrame:
    table = navigation_comparisons(scores, five_spaces)
    check(table, navigation_comparisons, five_spaces)
    return table


@pytest.fixture
def only_steps(monkeypatch) -> None:
    """The other measures and the Games-Howell test take most of the time."""
    monkeypatch.setattr(module, "MEASURES", (STEPS,))
    monkeypatch.setattr(module, "CROSS_CHECKED", ())


# ---- comparisons -----------------------------------------------------------------------------


def exact_permutation(a: np.ndarray, b: np.ndarray) -> float:
    """Twice the smaller tail of all ways to divide the runs."""
    together = np.concatenate([a, b])
    choices = combinations(range(len(together)), len(a))
    sums = np.array([together[list(chosen)].sum() for chosen in choices])
    return min(1.0, 2 * min((sums <= a.sum() + 1e-9).mean(), (sums >= a.sum() - 1e-9).mean()))


def check_welch(row, a, b):
    expected = stats.ttest_ind(a, b, equal_var=False)
    low, high = expected.confidence_interval()
    assert (row.statistic, row.df, row.p) == pytest.approx(
        (expected.statistic, expected.df, expected.pvalue)
    )
    assert (row.difference, row.ci_low, row.ci_high) == pytest.approx(
        (a.mean() - b.mean(), low, high)
    )
    assert row.effect == "Hedges' g" and np.sign(row.effect_size) == np.sign(row.difference)


def check_mann_whitney(row, a, b):
    expected = stats.mannwhitneyu(a, b)
    assert (row.statistic, row.p) == pytest.approx((expected.statistic, expected.pvalue))
    better = expected.statistic / 36 if row.measure != STEPS else 1 - expected.statistic / 36
    assert row.effect == "P(a better)" and row.effect_size == pytest.approx(better)
    assert row.ci_low <= better <= row.ci_high


def check_ranks(row, a, b):
    ranks = stats.rankdata(np.concatenate([a, b]))
    expected = stats.ttest_ind(ranks[:6], ranks[6:], equal_var=False)
    assert row.p == pytest.approx(expected.pvalue)


def check_permutation(row, a, b):
    assert row.difference == pytest.approx(a.mean() - b.mean())
    assert row.p == pytest.approx(exact_permutation(a, b))


def check_half(row, a, b):
    expected = stats.ttest_ind(a, b / 2, equal_var=False)
    assert (row.statistic, row.p) == pytest.approx((expected.statistic, expected.pvalue))
    assert row.df == pytest.approx(expected.df)
    assert row.effect_size == pytest.approx(a.mean() / b.mean())
    assert row.ci_low < row.effect_size < row.ci_high


CHECKS = {WELCH: check_welch, MANN_WHITNEY: check_mann_whitney, RANKS: check_ranks,
          PERMUTATION: check_permutation, HALF: check_half}  # fmt: skip


@pytest.mark.filterwarnings("ignore:Precision loss")
def test_every_test_is_what_scipy_and_statsmodels_say(comparisons, scores):
    assert 0 < (~scores["reached"]).sum() < 15  # some runs are censored
    assert values(scores, "full").min() < values(scores, "truncated").max()  # and groups overlap
    for row in comparisons.itertuples():
        a, b = values(scores, row.a, row.measure), values(scores, row.b, row.measure)
        if row.test in CHECKS:
            CHECKS[row.test](row, a, b)
        elif row.test == LOG_RANK:
            both = scores[scores["action_space"].isin([row.a, row.b])]
            chi2, p = survdiff(both[STEPS], both["reached"].astype(int), both["action_space"])
            assert (row.statistic**2, row.p) == pytest.approx((chi2, p))
        else:
            assert row.test == HOWELL
    for test, measures in {LOG_RANK: {STEPS}, HALF: {STEPS}, HOWELL: set(CROSS_CHECKED)}.items():
        assert set(comparisons.loc[comparisons["test"] == test, "measure"]) == measures
    assert set(comparisons["measure"]) == set(MEASURES)


def test_games_howell_is_over_the_family_in_either_order_of_a_pair(comparisons, scores):
    for family, spaces in (("paper", ("full", "truncated", "adapted")), ("controls", SPACES)):
        expected = games_howell({space: values(scores, space) for space in spaces})
        chosen = (comparisons["test"] == HOWELL) & (comparisons["measure"] == STEPS)
        for row in comparisons[chosen & (comparisons["family"] == family)].itertuples():
            a, b = values(scores, row.a), values(scores, row.b)
            assert row.difference == pytest.approx(a.mean() - b.mean())
            assert row.ci_low < row.difference < row.ci_high and row.p == row.p_adjusted
            pair = expected.get((row.a, row.b)) or expected[row.b, row.a]
            assert row.p == pytest.approx(pair.p, abs=1e-6)
            assert row.ci_high - row.ci_low == pytest.approx(pair.ci_high - pair.ci_low, rel=1e-4)


def test_holm_is_over_the_pairs_of_a_family_for_each_measure_and_test(comparisons):
    corrected = comparisons[comparisons["test"] != HOWELL]
    for (family, _, _), rows in corrected.groupby(["family", "measure", "test"]):
        assert len(rows) == (3 if family == "paper" else 7)
        expected = multipletests(rows["p"], method="holm")[1]
        assert rows["p_adjusted"].to_numpy() == pytest.approx(expected)
    assert (corrected["p_adjusted"] > corrected["p"]).any()
    for _, rows in comparisons.groupby(["a", "b", "measure"]):
        decisions = rows.set_index("test")["p_adjusted"] < ALPHA
        for row in rows.itertuples():
            agrees = "yes" if decisions[row.test] == decisions[WELCH] else "no"
            assert row.agrees == ("" if row.test in (WELCH, HALF) else agrees)
    assert set(comparisons["agrees"]) == {"", "yes", "no"}


def test_pairs_fall_into_two_families(default_config, five_spaces, scores, only_steps):
    families = pairs(five_spaces)
    assert [pair[1:] for pair in families[:3]] == PAPER_PAIRS
    assert [pair[0] for pair in families] == ["paper"] * 3 + ["controls"] * 7
    assert len({frozenset(pair[1:]) for pair in families}) == 10
    for spaces, controls in ((SPACES[:3], 0), (["inverse", "adapted", "full", "truncated"], 3)):
        config = with_spaces(default_config, spaces)
        table = navigation_comparisons(scores[scores["action_space"].isin(spaces)], config)
        assert len(pairs(config)) == 3 + controls
        assert set(table.loc[table["family"] == "controls", "b"]) <= {"inverse"}
        groups = table.groupby(["family", "test"])
        assert len(groups) == 6 * (1 + (controls > 0)) and (groups.size() == 3).all()


def test_signs_of_differences_and_effects(five_spaces, only_steps):
    """Every run reaches the threshold at the checkpoint of its space, two of six one later."""
    checkpoint = {"full": 3, "truncated": 1, "adapted": 2, "random-half": 4, "inverse": 9}
    curves = make_curves(
        five_spaces, lambda space, i, k: 40 if k >= checkpoint[space] + (i % 3 == 0) else 2
    )
    scores = navigation_scores(curves, five_spaces)
    table = navigation_comparisons(scores, five_spaces).set_index(["test", "a", "b"])
    welch, half = (table.loc[test, "truncated", "full"] for test in (WELCH, HALF))
    assert welch["difference"] == pytest.approx(-2 * STEP) and welch["effect_size"] < 0
    assert welch["ci_low"] < -2 * STEP < welch["ci_high"] < 0
    assert table.loc[MANN_WHITNEY, "truncated", "full"]["effect_size"] == 1
    assert table.loc[MANN_WHITNEY, "full", "inverse"]["effect_size"] == 1
    assert table.loc[LOG_RANK, "truncated", "full"]["statistic"] > 0
    assert half["effect_size"] == pytest.approx((4 * 1 + 2 * 2) / (4 * 3 + 2 * 4))
    assert half["statistic"] < 0 < table.loc[HALF, "adapted", "full"]["statistic"]
    summary = navigation_summary(scores, five_spaces).set_index(["action_space", "measure"])
    assert summary.loc[("full", "reached"), "mean"] == 1
    assert summary.loc[("inverse", "reached"), "mean"] == 0
    mean = (4 * 3 + 2 * 4) / 6 * STEP
    assert summary.loc[("full", STEPS), "mean"] == pytest.approx(mean)
    assert summary.loc[("full", STEPS), "median"] == 3 * STEP


def test_a_test_against_half_by_hand():
    """No difference from twice as fast; faster than that, and slower."""
    a, b = np.arange(1.0, 7), np.arange(2.0, 13, 2)
    for x, y, sign in ((a, b, 0), (a / 4, b, -1), (a, b / 2, 1)):
        frames = [pd.DataFrame({STEPS: steps, "reached": True}) for steps in (x, y)]
        *_, half = compare_steps({}, *frames, np.random.default_rng(0))
        assert half["test"] == HALF and np.sign(half["statistic"]) == sign
        assert half["effect_size"] == pytest.approx(x.mean() / y.mean())
        assert (half["p"] == pytest.approx(1)) == (sign == 0)


def test_the_same_scores_give_the_same_numbers(comparisons, scores, five_spaces, only_steps):
    again = navigation_comparisons(scores, five_spaces)
    chosen = (comparisons["test"] != HOWELL) & (comparisons["measure"] == STEPS)
    expected = comparisons[chosen].reset_index(drop=True)
    pd.testing.assert_frame_equal(again[expected.columns], expected)


def test_checkpoints_are_welchs_tests_of_the_returns_at_each(curves, five_spaces):
    table = navigation_checkpoints(curves, five_spaces)
    check(table, navigation_checkpoints, five_spaces)
    for row in table.itertuples():
        rows = curves[curves["step"] == row.step]
        a, b = (values(rows, space, "episode_return") for space in (row.a, row.b))
        assert row.p == pytest.approx(stats.ttest_ind(a, b, equal_var=False).pvalue)
        assert row.difference == pytest.approx(a.mean() - b.mean())
        assert row.ci_low < row.difference < row.ci_high
    for family, n in (("paper", 3), ("controls", 7)):
        rows = table[table["family"] == family]
        expected = multipletests(rows["p"], method="holm")[1]
        assert len(rows) == n * CHECKPOINTS
        assert rows["p_adjusted"].to_numpy() == pytest.approx(expected)


# ---- runs that do not differ, and runs that are missing --------------------------------------


def test_runs_without_spread_fill_all_tables(default_config):
    config = with_spaces(default_config, SPACES[:3])
    for value in (
        lambda space, i, k: -20.0,
        lambda space, i, k: 50.0 if space == "truncated" else 0.0,
        lambda space, i, k: 50.0 if (space, i) == ("truncated", 0) else 0.0,
    ):
        curves = make_curves(config, value)
        scores = navigation_scores(curves, config)
        frames = {"navigation_checkpoints": navigation_checkpoints(curves, config)}
        for table in FROM_SCORES:
            frames[table.name] = table(scores, config)
            check(frames[table.name], table, config)
        for name, frame in frames.items():
            for column in ("p", "p_adjusted", "power", "rate", "survival", "fraction"):
                assert column not in frame or frame[column].between(0, 1).all(), (name, column)
        rows = frames["navigation_comparisons"]
        equal = rows[(rows["a"] == "adapted") & (rows["b"] == "full")].set_index("test").drop(HALF)
        assert (equal["p"] == 1).all() and (equal["difference"].dropna() == 0).all()
        assert (equal.loc[MANN_WHITNEY, "effect_size"] == 0.5).all()


def test_every_run_must_be_scored_once(scores, five_spaces, tmp_path):
    path = tmp_path / "navigation_scores.parquet"
    for frame, message in (
        (scores[1:], "1 of 30 groups of rows missing: action_space full, seed 3"),
        (pd.concat([scores, scores[:1]]), "1 rows are repeated.*action_space full, seed 3"),
        (scores.assign(seed=scores["seed"] + 100), "30 of 30 groups of rows missing"),
    ):
        metadata = runner.metadata_of(navigation_scores, five_spaces, None)
        runner.write_table(path, "navigation_scores", navigation_scores.columns, frame, metadata)
        for table in FROM_SCORES:
            out = tmp_path / f"{table.name}.parquet"
            with pytest.raises(TableError, match=message):
                runner.write_product(table, five_spaces, [path], out)
            assert not out.exists()


# ---- survival, profiles, power, calibration --------------------------------------------------


def make_scores(**columns) -> pd.DataFrame:
    """A table navigation_scores; columns are numbers, or lists with a value for each seed."""
    runs = [(space, seed) for space in SPACES for seed in SEEDS]
    defaults = dict(final_return=0.0, auc=0.0, success_rate=0.0, reached=True, solved=False)
    columns = defaults | {STEPS: 1.0} | columns
    repeated = {name: x * 5 if isinstance(x, list) else x for name, x in columns.items()}
    return pd.DataFrame(runs, columns=["action_space", "seed"]).assign(**repeated)


def test_survival_by_hand(five_spaces):
    """Of six runs, one reaches the threshold at the first checkpoint, two at the third."""
    steps = [STEP, 5.0 * STEP, 3.0 * STEP, 3.0 * STEP, 5.0 * STEP, 5.0 * STEP]
    reached = [True, False, True, True, False, False]
    scores = make_scores(steps_to_threshold=steps, reached=reached)
    table = navigation_survival(scores, five_spaces)
    check(table, navigation_survival, five_spaces)
    assert list(dict.fromkeys(table["action_space"])) == SPACES
    for _, rows in table.groupby("action_space"):
        assert rows["step"].tolist() == [0, STEP, 3 * STEP, 5 * STEP]
        assert rows["at_risk"].tolist() == [6, 6, 5, 3] and rows["events"].tolist() == [0, 1, 2, 0]
        assert rows["survival"].tolist() == pytest.approx([1, 5 / 6, 1 / 2, 1 / 2])
        assert (rows["ci_low"] <= rows["survival"]).all()
        assert (rows["survival"] <= rows["ci_high"]).all()


def test_profiles_by_hand(five_spaces):
    scores = make_scores(final_return=[-20.0, -0.5, 0.0, 24.75, 50.0, 50.0])
    table = navigation_profiles(scores, five_spaces)
    check(table, navigation_profiles, five_spaces)
    for _, rows in table.groupby("action_space"):
        assert rows["threshold"].iloc[[0, -1]].tolist() == [-20.0, 50.0]
        assert rows["threshold"].is_monotonic_increasing and (rows["n"] == 6).all()
        above = dict(zip(rows["threshold"].round(9), rows["above"], strict=True))
        assert [above[tau] for tau in (-20.0, -19.5, 0.0, 0.5, 50.0)] == [6, 5, 4, 3, 2]
        assert rows["fraction"].tolist() == (rows["above"] / 6).tolist()
        assert (rows["ci_low"] <= rows["fraction"]).all()
        assert (rows["fraction"] <= rows["ci_high"]).all()


def test_power_is_what_statsmodels_says(scores, five_spaces):
    table, reference = navigation_power(scores, five_spaces), TTestIndPower()
    check(table, navigation_power, five_spaces)
    power_at = table[table["question"] == POWER_AT]
    assert power_at[["alpha", "effect_size"]].values.tolist() == [
        [alpha, d] for alpha in (ALPHA, ALPHA / 3) for d in EFFECTS
    ]
    detectable = table[table["question"] == DETECTABLE]
    assert len(detectable) == 2 and (detectable["power"] == 0.8).all()
    for row in pd.concat([power_at, detectable]).itertuples():
        expected = reference.power(row.effect_size, 6, row.alpha)
        assert row.n == 6 and row.power == pytest.approx(expected, abs=1e-6)
    needed = table[table["question"] == NEEDED]
    assert list(zip(needed["a"], needed["b"], strict=True)) == PAPER_PAIRS
    assert np.isfinite(needed["n"]).any()
    for row in needed.itertuples():
        a, b = values(scores, row.a, "final_return"), values(scores, row.b, "final_return")
        g = (a.mean() - b.mean()) / np.sqrt((a.var(ddof=1) + b.var(ddof=1)) / 2) * (1 - 3 / 39)
        assert row.effect_size == pytest.approx(g) and row.alpha == pytest.approx(ALPHA / 3)
        if np.isfinite(row.n):
            assert reference.power(abs(g), row.n, row.alpha) >= 0.8 - 1e-6
            assert row.n == 2 or reference.power(abs(g), row.n - 1, row.alpha) < 0.8


def test_calibration_shares_the_splits_and_rounds_up(scores, five_spaces):
    table = navigation_calibration(scores, five_spaces)
    check(table, navigation_calibration, five_spaces)
    assert table["measure"].unique().tolist() == list(CALIBRATED)
    assert table["method"].unique().tolist() == ["halves", "resampled"]
    for (_, measure), rows in table.groupby(["method", "measure"]):
        assert rows["action_space"].tolist() == [*SPACES, "all"]
        *alone, together = rows.itertuples()
        assert [row.splits for row in alone] == [11] * 5
        n = 11 * sum(np.ptp(values(scores, space, measure)) > 0 for space in SPACES)
        assert together.splits == n and together.rejected == sum(row.rejected for row in alone)
        assert (rows["rate"] == rows["rejected"] / rows["splits"]).all()
        assert (rows["alpha"] == ALPHA).all()
        band = stats.binom.ppf([0.025, 0.975], n, ALPHA) / n
        assert (together.band_low, together.band_high) == pytest.approx(tuple(band))
    constant = navigation_calibration(make_scores(), five_spaces)
    assert (constant["rejected"] == 0).all()
    assert (constant.loc[constant["action_space"] == "all", "splits"] == 0).all()
