"""The tables that learning curves become, against numbers worked out another way; runs in which nothing differs; settings; commands."""

from __future__ import annotations

import sys
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from tests.helpers import DEFAULT
from statsmodels.duration.survfunc import survdiff
from statsmodels.stats.multitest import multipletests
from statsmodels.stats.power import TTestIndPower

from sensory_commutativity import cli
from sensory_commutativity.errors import ConfigError, TableError
from sensory_commutativity.statistics.groups import games_howell
from sensory_commutativity.storage.tables import read_table, write_table
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load, validate
from sensory_commutativity.studies.navigation.tables import navigation_comparisons
from sensory_commutativity.studies.navigation.tables.navigation_calibration import (
    CALIBRATED,
    write_calibration,
)
from sensory_commutativity.studies.navigation.tables.navigation_checkpoints import (
    compare_checkpoints,
    write_checkpoints,
)
from sensory_commutativity.studies.navigation.tables.navigation_comparisons import (
    CROSS_CHECKED,
    HALF,
    LOG_RANK,
    RANKS,
    STEPS,
    WELCH,
    compare,
    pairs,
    write_comparisons,
)
from sensory_commutativity.studies.navigation.tables.navigation_curves import gather_curves
from sensory_commutativity.studies.navigation.tables.navigation_power import (
    DETECTABLE,
    EFFECTS,
    NEEDED,
    POWER_AT,
    write_power,
)
from sensory_commutativity.studies.navigation.tables.navigation_profiles import write_profiles
from sensory_commutativity.studies.navigation.tables.navigation_scores import (
    MEASURES,
    score_runs,
    write_scores,
)
from sensory_commutativity.studies.navigation.tables.navigation_summary import write_summary
from sensory_commutativity.studies.navigation.tables.navigation_survival import write_survival

SPACES = ["full", "truncated", "adapted", "random-half", "inverse"]
SEEDS = [0, 1, 2, 3, 4, 5]
STEP, CHECKPOINTS = 2048, 5
ALPHA = 0.05  # as in the default profile
SPEED = {"truncated": 1.5, "adapted": 2.0, "full": 2.5, "random-half": 3.0, "inverse": 4.5}


def of_spaces(spaces: list[str], **more) -> Config:
    settings = load(DEFAULT)
    update = dict(
        action_spaces=spaces,
        seeds=SEEDS,
        steps=CHECKPOINTS * STEP,
        checkpoints=CHECKPOINTS,
        calibration_splits=51,
        evaluation_episodes=10,
        **more,
    )
    return settings.model_copy(update={"navigation": settings.navigation.model_copy(update=update)})


def curves_of(config: Config, value) -> pd.DataFrame:
    """Curves whose returns are value(action space, number of the run, checkpoint from 1)."""
    rows = [
        (space, seed, k * STEP, value(space, i, k), 0.5, 0.1, 50.0, 10)
        for space in config.navigation.action_spaces
        for i, seed in enumerate(SEEDS)
        for k in range(1, CHECKPOINTS + 1)
    ]
    return pd.DataFrame(
        rows,
        columns=[
            "action_space",
            "seed",
            "step",
            "episode_return",
            "success_rate",
            "dead_rate",
            "episode_length",
            "episodes",
        ],
    )


@pytest.fixture(scope="module")
def config() -> Config:
    return of_spaces(SPACES)


@pytest.fixture(scope="module")
def curves(config) -> pd.DataFrame:
    """Noisy runs that overlap; some never get there."""
    rng = np.random.default_rng(3)
    start = {(space, i): SPEED[space] + rng.normal(0, 1.3) for space in SPACES for i in range(6)}
    frame = curves_of(
        config, lambda space, i, k: 40 / (1 + np.exp(-2 * (k - start[space, i]))) + rng.normal(0, 2)
    )
    return frame.assign(success_rate=(frame["episode_return"] / 50).clip(0, 1))


@pytest.fixture(scope="module")
def scores(curves, config) -> pd.DataFrame:
    return score_runs(curves, config)


@pytest.fixture(scope="module")
def few(scores) -> tuple[Config, pd.DataFrame]:
    """The paper's three action spaces alone: Games and Howell's test of five takes seconds."""
    config = of_spaces(SPACES[:3])
    return config, compare(scores[scores["action_space"].isin(SPACES[:3])], config)


@pytest.fixture
def scores_file(scores, config, tmp_path) -> Path:
    write_table("navigation_scores", scores, tmp_path / "scores.parquet", config)
    return tmp_path / "scores.parquet"


def values(scores, space, measure=STEPS) -> np.ndarray:
    return scores.loc[scores["action_space"] == space, measure].to_numpy()


# ---- comparisons -----------------------------------------------------------------------------------------------------------


def test_the_runs_overlap_and_some_are_censored(scores):
    assert 0 < (~scores["reached"]).sum() < 15
    assert values(scores, "full").min() < values(scores, "truncated").max()


def exact_permutation(a: np.ndarray, b: np.ndarray) -> float:
    """Twice the smaller tail of all ways to divide the runs."""
    together = np.concatenate([a, b])
    sums = np.array(
        [together[list(chosen)].sum() for chosen in combinations(range(len(together)), len(a))]
    )
    return min(1.0, 2 * min((sums <= a.sum() + 1e-9).mean(), (sums >= a.sum() - 1e-9).mean()))


def test_every_test_is_what_scipy_and_statsmodels_say(few, scores):
    _, table = few
    for row in table.itertuples():
        a, b = values(scores, row.a, row.measure), values(scores, row.b, row.measure)
        if row.test == WELCH:
            expected = stats.ttest_ind(a, b, equal_var=False)
            low, high = expected.confidence_interval()
            assert (row.statistic, row.df, row.p) == pytest.approx(
                (expected.statistic, expected.df, expected.pvalue)
            )
            assert (row.difference, row.ci_low, row.ci_high) == pytest.approx(
                (a.mean() - b.mean(), low, high)
            )
            assert row.effect == "Hedges' g" and np.sign(row.effect_size) == np.sign(row.difference)
        elif row.test == "Mann-Whitney":
            expected = stats.mannwhitneyu(a, b)
            assert (row.statistic, row.p) == pytest.approx((expected.statistic, expected.pvalue))
            better = (
                expected.statistic / 36 if row.measure != STEPS else 1 - expected.statistic / 36
            )
            assert (
                row.effect_size == pytest.approx(better)
                and row.effect == "P(a better)"
                and row.ci_low <= better <= row.ci_high
            )
        elif row.test == RANKS:
            together = stats.rankdata(np.concatenate([a, b]))
            assert row.p == pytest.approx(
                stats.ttest_ind(together[:6], together[6:], equal_var=False).pvalue
            )
        elif row.test == "permutation":
            assert row.difference == pytest.approx(a.mean() - b.mean())
            assert row.p == pytest.approx(exact_permutation(a, b))
        elif row.test == LOG_RANK:
            both = scores[scores["action_space"].isin([row.a, row.b])]
            chi2, p = survdiff(both[STEPS], both["reached"].astype(int), both["action_space"])
            assert (row.statistic**2, row.p) == pytest.approx((chi2, p))
        elif row.test == HALF:
            expected = stats.ttest_ind(a, b / 2, equal_var=False)
            assert (row.statistic, row.p) == pytest.approx((expected.statistic, expected.pvalue))
            assert row.df == pytest.approx(expected.df)
            assert (
                row.effect_size == pytest.approx(a.mean() / b.mean())
                and row.ci_low < row.effect_size < row.ci_high
            )


def test_steps_alone_have_tests_of_times(few):
    _, table = few
    assert set(table.loc[table["test"].isin([LOG_RANK, HALF]), "measure"]) == {STEPS}
    assert set(table["measure"]) == set(MEASURES)
    assert set(table.loc[table["test"] == "Games-Howell", "measure"]) == set(CROSS_CHECKED)


def test_a_test_against_half_by_hand(config):
    """Twice as fast to the checkpoint: nothing to find; faster than that, and slower, with their signs."""
    a, b = np.array([1.0, 2, 3, 4, 5, 6]), np.array([2.0, 4, 6, 8, 10, 12])
    for x, y, sign in ((a, b, 0), (a / 4, b, -1), (a, b / 2, 1)):
        frames = [pd.DataFrame({STEPS: steps, "reached": True}) for steps in (x, y)]
        *_, half = navigation_comparisons._steps({}, *frames, np.random.default_rng(0))
        assert half["test"] == HALF and np.sign(half["statistic"]) == sign
        assert half["effect_size"] == pytest.approx(x.mean() / y.mean())
        assert (half["p"] == pytest.approx(1)) == (sign == 0)


def test_games_howell_is_over_the_family_whichever_way_a_pair_is_named(few, scores):
    _, table = few
    for measure in CROSS_CHECKED:
        together = games_howell(
            {space: values(scores, space, measure) for space in ("full", "truncated", "adapted")}
        )
        rows = table[(table["test"] == "Games-Howell") & (table["measure"] == measure)]
        assert len(rows) == 3
        for row in rows.itertuples():
            assert row.difference == pytest.approx(
                values(scores, row.a, measure).mean() - values(scores, row.b, measure).mean()
            )
            assert row.ci_low < row.difference < row.ci_high and row.p == row.p_adjusted
            pair = together[row.a, row.b] if (row.a, row.b) in together else together[row.b, row.a]
            assert row.p == pytest.approx(
                pair.p, abs=1e-6
            ) and row.ci_high - row.ci_low == pytest.approx(pair.ci_high - pair.ci_low, rel=1e-4)


def test_holm_by_hand(few):
    _, table = few
    rows = table[(table["test"] == WELCH) & (table["measure"] == "final_return")].sort_values("p")
    p = rows["p"].to_numpy()
    expected = np.minimum(1, np.maximum.accumulate(p * [3, 2, 1]))
    assert rows["p_adjusted"].to_numpy() == pytest.approx(expected)


def test_without_controls_there_is_one_family(few):
    config, table = few
    assert set(table["family"]) == {"paper"} and len(pairs(config)) == 3


def only_steps(monkeypatch) -> None:
    """All measures and Games and Howell's test take most of the time."""
    monkeypatch.setattr(navigation_comparisons, "MEASURES", (STEPS,))
    monkeypatch.setattr(navigation_comparisons, "CROSS_CHECKED", ())


def test_with_one_control_its_pairs_are_a_family_of_their_own(monkeypatch, scores):
    only_steps(monkeypatch)
    config = of_spaces(["inverse", "adapted", "full", "truncated"])
    table = compare(scores[scores["action_space"] != "random-half"], config)
    assert table.groupby("family")[["a", "b"]].apply(
        lambda rows: len(rows.drop_duplicates())
    ).to_dict() == {"controls": 3, "paper": 3}
    assert set(table.loc[table["family"] == "controls", "b"]) == {"inverse"}
    for _, rows in table.groupby(["family", "measure", "test"]):
        assert len(rows) == 3 and rows["p_adjusted"].to_numpy() == pytest.approx(
            multipletests(rows["p"], method="holm")[1]
        )


def test_the_same_scores_give_the_same_numbers(few, scores, monkeypatch):
    only_steps(monkeypatch)
    config, table = few
    again = compare(scores[scores["action_space"].isin(SPACES[:3])], config)
    expected = table[(table["test"] != "Games-Howell") & (table["measure"] == STEPS)].reset_index(
        drop=True
    )
    pd.testing.assert_frame_equal(again[expected.columns], expected)


def test_checkpoints_are_welchs_tests_of_the_returns_there(curves, config):
    table = compare_checkpoints(curves, config)
    for row in table.itertuples():
        here = curves[curves["step"] == row.step]
        a, b = (
            here.loc[here["action_space"] == space, "episode_return"] for space in (row.a, row.b)
        )
        assert row.p == pytest.approx(
            stats.ttest_ind(a, b, equal_var=False).pvalue
        ) and row.difference == pytest.approx(a.mean() - b.mean())
        assert row.ci_low < row.difference < row.ci_high
    for family, n in (("paper", 3), ("controls", 7)):
        rows = table[table["family"] == family]
        assert len(rows) == n * CHECKPOINTS and rows["p_adjusted"].to_numpy() == pytest.approx(
            multipletests(rows["p"], method="holm")[1]
        )


# ---- where nothing differs -------------------------------------------------------------------------------------------------


WRITERS = {
    "navigation_summary": write_summary,
    "navigation_comparisons": write_comparisons,
    "navigation_survival": write_survival,
    "navigation_profiles": write_profiles,
    "navigation_power": write_power,
    "navigation_calibration": write_calibration,
}
SAME = {
    "nobody learns": lambda space, i, k: -20.0,
    "one differs": lambda space, i, k: 50.0 if space == "truncated" else 0.0,
    "one run differs": lambda space, i, k: 50.0 if (space, i) == ("truncated", 0) else 0.0,
}


@pytest.mark.parametrize("value", SAME.values(), ids=SAME)
def test_runs_without_any_spread_fill_all_tables(value, tmp_path):
    config = of_spaces(SPACES[:3])
    write_table("navigation_curves", curves_of(config, value), tmp_path / "curves.parquet", config)
    write_scores(tmp_path / "curves.parquet", tmp_path / "scores.parquet", config)
    write_checkpoints(tmp_path / "curves.parquet", tmp_path / "checkpoints.parquet", config)
    for name, write in WRITERS.items():
        write(tmp_path / "scores.parquet", tmp_path / f"{name}.parquet", config)
        table = read_table(name, tmp_path / f"{name}.parquet")
        for column in table.columns.intersection(
            ["p", "p_adjusted", "power", "rate", "survival", "fraction"]
        ):
            assert table[column].between(0, 1).all(), (name, column)
    comparisons = read_table("navigation_comparisons", tmp_path / "navigation_comparisons.parquet")
    equal = comparisons[
        (comparisons["a"] == "adapted")
        & (comparisons["b"] == "full")
        & (comparisons["test"] != HALF)
    ]
    assert (equal["p"] == 1).all() and (equal["difference"].dropna() == 0).all()
    assert (equal.loc[equal["test"] == "Mann-Whitney", "effect_size"] == 0.5).all()


# ---- scores, survival, profiles --------------------------------------------------------------------------------------------


def test_scores_of_a_run_by_hand():
    config = of_spaces(SPACES[:3], threshold_return=10.0, solved_success_rate=0.5)
    curve = [0.0, 12.0, 9.0, 10.0, 8.0]
    table = score_runs(
        curves_of(config, lambda space, i, k: curve[k - 1]).sample(frac=1, random_state=2), config
    )
    assert len(table) == 18
    for row in table.itertuples():
        assert (row.final_return, row.auc, row.success_rate) == (8.0, pytest.approx(39 / 5), 0.5)
        assert (row.steps_to_threshold, row.reached, row.solved) == (2 * STEP, True, True)
    late = score_runs(curves_of(config, lambda space, i, k: 9.99 if k < 5 else 10.0), config)
    assert late["reached"].all() and (late["steps_to_threshold"] == 5 * STEP).all()
    never = score_runs(curves_of(config, lambda space, i, k: 9.99), config)
    assert not never["reached"].any() and (never["steps_to_threshold"] == 5 * STEP).all()


def test_survival_by_hand(config, tmp_path):
    """Six runs: one there at the first checkpoint, two at the third, three never."""
    frame = pd.DataFrame([(space, seed) for space in SPACES for seed in SEEDS], columns=["action_space", "seed"]).assign(
        final_return=0.0, auc=0.0, success_rate=0.0, solved=False, reached=[True, False, True, True, False, False] * 5,
        steps_to_threshold=np.array([1.0, 5, 3, 3, 5, 5] * 5) * STEP,
    )  # fmt: skip
    write_table("navigation_scores", frame, tmp_path / "scores.parquet", config)
    write_survival(tmp_path / "scores.parquet", tmp_path / "out.parquet", config)
    table = read_table("navigation_survival", tmp_path / "out.parquet")
    assert list(dict.fromkeys(table["action_space"])) == SPACES
    for _, rows in table.groupby("action_space"):
        assert rows["step"].tolist() == [0, STEP, 3 * STEP, 5 * STEP]
        assert rows["at_risk"].tolist() == [6, 6, 5, 3] and rows["events"].tolist() == [0, 1, 2, 0]
        assert rows["survival"].tolist() == pytest.approx([1, 5 / 6, 1 / 2, 1 / 2])
        assert (rows["ci_low"] <= rows["survival"]).all() and (
            rows["survival"] <= rows["ci_high"]
        ).all()


def test_profiles_by_hand(config, tmp_path):
    returns = [-20.0, -0.5, 0.0, 24.75, 50.0, 50.0]
    frame = pd.DataFrame(
        [(space, seed) for space in SPACES for seed in SEEDS], columns=["action_space", "seed"]
    ).assign(
        final_return=returns * 5,
        auc=0.0,
        success_rate=0.0,
        solved=False,
        reached=True,
        steps_to_threshold=1.0,
    )
    write_table("navigation_scores", frame, tmp_path / "scores.parquet", config)
    write_profiles(tmp_path / "scores.parquet", tmp_path / "out.parquet", config)
    table = read_table("navigation_profiles", tmp_path / "out.parquet")
    for _, rows in table.groupby("action_space"):
        assert (
            rows["threshold"].iloc[[0, -1]].tolist() == [-20.0, 50.0]
            and rows["threshold"].is_monotonic_increasing
        )
        at = {
            round(row.threshold, 9): (row.above, row.fraction, row.n) for row in rows.itertuples()
        }
        assert (
            at[-20.0] == (6, 1.0, 6)
            and at[-19.5] == (5, 5 / 6, 6)
            and at[0.0] == (4, 4 / 6, 6)
            and at[0.5] == (3, 0.5, 6)
        )
        assert at[50.0] == (2, 2 / 6, 6)
        assert (rows["ci_low"] <= rows["fraction"]).all() and (
            rows["fraction"] <= rows["ci_high"]
        ).all()


# ---- power, calibration ----------------------------------------------------------------------------------------------------


def test_power_is_what_statsmodels_says(scores_file, scores, config, tmp_path):
    write_power(scores_file, tmp_path / "out.parquet", config)
    table, theirs = read_table("navigation_power", tmp_path / "out.parquet"), TTestIndPower()
    at = table[table["question"] == POWER_AT]
    assert at[["alpha", "effect_size"]].values.tolist() == [
        [alpha, d] for alpha in (ALPHA, ALPHA / 3) for d in EFFECTS
    ]
    for row in at.itertuples():
        assert row.n == 6 and row.power == pytest.approx(
            theirs.power(row.effect_size, 6, row.alpha), abs=1e-6
        )
    for row in table[table["question"] == DETECTABLE].itertuples():
        assert (
            row.n == 6
            and theirs.power(row.effect_size, 6, row.alpha) == pytest.approx(row.power, abs=1e-6)
            and row.power == 0.8
        )
    needed = table[table["question"] == NEEDED]
    assert needed[["a", "b"]].values.tolist() == [
        ["truncated", "adapted"],
        ["truncated", "full"],
        ["adapted", "full"],
    ]
    for row in needed.itertuples():
        a, b = values(scores, row.a, "final_return"), values(scores, row.b, "final_return")
        g = (a.mean() - b.mean()) / np.sqrt((a.var(ddof=1) + b.var(ddof=1)) / 2) * (1 - 3 / 39)
        assert row.effect_size == pytest.approx(g) and row.alpha == pytest.approx(ALPHA / 3)
        if np.isfinite(row.n):
            assert theirs.power(abs(g), row.n, row.alpha) >= 0.8 - 1e-6 and (
                row.n == 2 or theirs.power(abs(g), row.n - 1, row.alpha) < 0.8
            )


def test_calibration_shares_the_splits_and_rounds_up(scores_file, scores, config, tmp_path):
    write_calibration(scores_file, tmp_path / "out.parquet", config)
    table = read_table("navigation_calibration", tmp_path / "out.parquet")
    assert table["measure"].unique().tolist() == list(CALIBRATED)
    assert table["method"].unique().tolist() == ["halves", "resampled"]
    for (_, measure), rows in table.groupby(["method", "measure"]):
        assert (
            rows["action_space"].tolist() == [*SPACES, "all"]
            and rows["splits"].tolist()[:5] == [11] * 5
        )
        n = 11 * sum(np.ptp(values(scores, space, measure)) > 0 for space in SPACES)
        assert (
            rows["splits"].iloc[5] == n
            and rows["rejected"].iloc[:5].sum() == rows["rejected"].iloc[5]
        )
        assert (rows["rate"] == rows["rejected"] / rows["splits"]).all() and (
            rows["alpha"] == ALPHA
        ).all()
        band = stats.binom.ppf([0.025, 0.975], n, ALPHA) / n
        assert rows[["band_low", "band_high"]].iloc[5].tolist() == pytest.approx(band.tolist())


def test_calibration_finds_nothing_where_nothing_is(config, tmp_path):
    frame = score_runs(curves_of(config, lambda space, i, k: 3.0), config)
    write_table("navigation_scores", frame, tmp_path / "scores.parquet", config)
    write_calibration(tmp_path / "scores.parquet", tmp_path / "out.parquet", config)
    table = read_table("navigation_calibration", tmp_path / "out.parquet")
    assert (table["rejected"] == 0).all() and (
        table.loc[table["action_space"] == "all", "splits"] == 0
    ).all()


def test_a_test_that_finds_otherwise_is_marked(few):
    config, table = few
    found = table.set_index(["a", "b", "measure", "test"])
    for (a, b, measure, test), row in found.iterrows():
        if test in (WELCH, HALF):
            assert row["agrees"] == ""
        else:
            decided = (
                found.loc[(a, b, measure, WELCH), "p_adjusted"].item() < config.navigation.alpha
            )
            assert (row["agrees"] == "yes") == (
                (row["p_adjusted"] < config.navigation.alpha) == decided
            )


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda s: s[1:], "1 of 30 training runs missing .truncated 0|missing .full 0"),
        (lambda s: pd.concat([s, s[:1]]), "repeated .full 0"),
        (lambda s: s.assign(seed=s["seed"] + 1), "missing"),
    ],
)
def test_what_is_made_from_scores_wants_every_run_once(spoil, message, scores, config, tmp_path):
    write_table("navigation_scores", spoil(scores), tmp_path / "scores.parquet", config)
    for write in WRITERS.values():
        with pytest.raises(TableError, match=message):
            write(tmp_path / "scores.parquet", tmp_path / "out.parquet", config)
    assert not (tmp_path / "out.parquet").exists()


# ---- settings --------------------------------------------------------------------------------------------------------------


OUT_OF_RANGE = {
    "learner.rooms": 0, "learner.rollout_steps": 3, "learner.batch_size": 3, "learner.epochs": 0, "learner.learning_rate": 0.0,
    "learner.discount": 1.0, "learner.gae_lambda": 1.1, "learner.clip_range": 0.0, "learner.entropy_coefficient": -0.1,
    "learner.value_coefficient": -0.1, "learner.max_gradient_norm": 0.0, "learner.features": 0, "learner.memory": 0,
    "learner.initial_log_std": 2.1, "learner.reward_scale": 0.0, "max_episode_steps": 0, "steps": 0, "checkpoints": 1,
    "evaluation_episodes": 1, "solved_success_rate": 1.1, "calibration_splits": 9, "zones": [], "action_spaces": ["full"],
    "threshold_return": "25", "world": "Arena", "agent": 3, "scp_world": "no such",
}  # fmt: skip


@pytest.mark.parametrize(("key", "value"), OUT_OF_RANGE.items(), ids=OUT_OF_RANGE)
def test_a_value_out_of_range_is_named_with_its_key(key, value, default_settings):
    *sections, name = key.split(".")
    section = default_settings["navigation"]
    for part in sections:
        section = section.setdefault(part, {})
    section[name] = value
    with pytest.raises(ConfigError, match=rf"^config: navigation\.{key}\b"):
        validate(default_settings)


@pytest.mark.parametrize(
    ("key", "value"), {"x": -1.0, "y": 5001.0, "radius": 0.0, "reward": 1001.0}.items()
)
def test_a_zone_out_of_range_is_named_with_its_key(key, value, default_settings):
    default_settings["navigation"]["zones"][2][key] = value
    with pytest.raises(ConfigError, match=rf"^config: navigation\.zones\.2\.{key}\b"):
        validate(default_settings)


@pytest.mark.parametrize(
    ("section", "wrong", "meant"),
    [("navigation", "check_points", "checkpoints"), ("learner", "epoch", "epochs")],
)
def test_a_mistyped_key_is_answered_with_the_one_that_was_meant(
    section, wrong, meant, default_settings
):
    where = (
        default_settings["navigation"]
        if section == "navigation"
        else default_settings["navigation"].setdefault("learner", {})
    )
    where[wrong] = 3
    with pytest.raises(ConfigError, match=f"{wrong}: unknown key; did you mean '{meant}'"):
        validate(default_settings)


def test_zones_may_touch_each_other_and_the_walls(default_settings):
    zones = [
        {"x": 50.0, "y": 50.0, "radius": 50.0, "reward": 50.0},
        {"x": 150.0, "y": 50.0, "radius": 50.0, "reward": -20.0},
    ]
    default_settings["navigation"]["zones"] = zones
    assert len(validate(default_settings).navigation.zones) == 2
    zones[1]["x"] = 149.0
    with pytest.raises(
        ConfigError, match=r"\(150, 50\)|\(149, 50\) overlaps the one at \(50, 50\)"
    ):
        validate(default_settings)


def test_the_threshold_may_be_the_best_reward(default_settings):
    default_settings["navigation"]["threshold_return"] = 50.0
    assert validate(default_settings).navigation.threshold_return == 50
    default_settings["navigation"]["threshold_return"] = 50.5
    with pytest.raises(ConfigError, match=r"navigation: threshold_return 50.5"):
        validate(default_settings)


def test_the_remedy_for_steps_is_one(default_settings):
    default_settings["navigation"]["steps"] = 1
    with pytest.raises(ConfigError) as told:
        validate(default_settings)
    default_settings["navigation"]["steps"] = int(
        str(told.value).rsplit("set it to ", 1)[1].split()[0]
    )
    assert (
        validate(default_settings).navigation.steps == default_settings["navigation"]["steps"] > 0
    )


def test_any_agent_whose_scp_is_measured_may_learn(default_settings):
    flatland = default_settings["flatland"]
    default_settings["navigation"].update(
        agent=flatland["reference"]["agent"], scp_world=flatland["reference"]["world"]
    )
    assert validate(default_settings).navigation.agent == flatland["reference"]["agent"]
    flatland["variants"]["agents"] = [
        agent for agent in flatland["variants"]["agents"] if agent != "sprinter"
    ]
    default_settings["navigation"].update(agent="sprinter", scp_world="furnished")
    with pytest.raises(
        ConfigError,
        match=r"navigation needs the SCP of 'sprinter' in 'furnished'.*flatland\.variants",
    ):
        validate(default_settings)


# ---- commands --------------------------------------------------------------------------------------------------------------


@pytest.fixture
def cli_run(monkeypatch, capsys, tmp_path):
    """The entry point, called in this process, in an empty folder: exit code and what stands on stderr."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["sensory-commutativity", *map(str, arguments)])
        code = 0
        try:
            cli.run()
        except SystemExit as leave:
            code = leave.code or 0
        return code, capsys.readouterr().err

    return call


RUN = (
    "navigation-run",
    "--config",
    DEFAULT,
    "--navigation-scp",
    "scp.parquet",
    "--model",
    "m.pt",
    "--out",
    "o.parquet",
)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((*RUN, "--action-space", "short", "--seed", 0), "'short' with seed 0; it has full, truncated, adapted, random-half, inverse, each with"),
        ((*RUN, "--action-space", "full", "--seed", 7), "'full' with seed 7; it has full, truncated, adapted, random-half, inverse, each with"),
        ((*RUN, "--action-space", "full", "--seed", -1), "-1 is not in the range x>=0"),
        ((*RUN, "--action-space", "full", "--seed", 2000), "scp.parquet: there is no such table"),
        (("navigation-curves", "--config", DEFAULT, "--out", "o.parquet", "a.parquet"), "a.parquet: there is no such table"),
        (("navigation-scores", "--config", DEFAULT, "--navigation-curves", "c.parquet", "--out", "o.parquet"), "c.parquet: there is no such table"),
        (("navigation-episode", "--config", DEFAULT, "--action-space", "short", "--navigation-scores", "s", "--models", "m", "--out", "o.gif"),
         "there is no action space 'short'; choose one of full, truncated"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_said_in_one_line(arguments, said, cli_run, tmp_path):
    code, err = cli_run(*arguments)
    assert (
        code == 2
        and said in err
        and err.count("\n") == 1
        and err.startswith("sensory-commutativity: error: ")
    )
    assert not list(tmp_path.iterdir())


def test_tables_are_made_from_the_table_that_a_command_asks_for(cli_run, curves, tmp_path):
    config = load(DEFAULT)
    navigation = config.navigation
    step = navigation.steps // navigation.checkpoints
    rows = [
        (space, seed, k * step, 10.0 * k + i, 0.9, 0.0, 30.0, 50)
        for space in navigation.action_spaces
        for i, seed in enumerate(navigation.seeds)
        for k in range(1, navigation.checkpoints + 1)
    ]
    frame = pd.DataFrame(rows, columns=curves.columns)
    write_table(
        "navigation_curves", frame.sample(frac=1, random_state=0), tmp_path / "part.parquet", config
    )
    where = ("--config", DEFAULT, "--out")
    assert cli_run("navigation-curves", *where, "curves.parquet", "part.parquet")[0] == 0
    for table, source in (
        ("scores", "curves"),
        ("checkpoints", "curves"),
        ("survival", "scores"),
        ("profiles", "scores"),
        ("power", "scores"),
    ):
        assert cli_run(
            f"navigation-{table}",
            f"--navigation-{source}",
            f"{source}.parquet",
            *where,
            f"{table}.parquet",
        ) == (0, "")
        read_table(f"navigation_{table}", tmp_path / f"{table}.parquet")
    assert read_table("navigation_curves", tmp_path / "curves.parquet")[
        list(frame.columns[:3])
    ].values.tolist() == [list(row[:3]) for row in rows]
    gather_curves([tmp_path / "part.parquet"], tmp_path / "again.parquet", config)
    pd.testing.assert_frame_equal(
        read_table("navigation_curves", tmp_path / "curves.parquet"),
        read_table("navigation_curves", tmp_path / "again.parquet"),
    )
    pd.testing.assert_frame_equal(
        read_table("navigation_scores", tmp_path / "scores.parquet"), score_runs(frame, config)
    )
    assert len(read_table("navigation_power", tmp_path / "power.parquet")) == 13
