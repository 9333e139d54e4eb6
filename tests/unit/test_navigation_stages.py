"""From learning curves to scores, comparisons and claims; settings that are refused; commands."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from tests.helpers import DEFAULT, ROOT
from statsmodels.stats.multitest import multipletests

from sensory_commutativity.cli import main
from sensory_commutativity.errors import ConfigError, TableError
from sensory_commutativity.storage.tables import read_table, write_table
from sensory_commutativity.studies.loading import load, validate
from sensory_commutativity.studies.navigation.builders import check_navigation
from sensory_commutativity.studies.navigation.tables.navigation_calibration import write_calibration
from sensory_commutativity.studies.navigation.tables.navigation_checkpoints import (
    compare_checkpoints,
)
from sensory_commutativity.studies.navigation.tables.navigation_comparisons import (
    HALF,
    LOG_RANK,
    STEPS,
    WELCH,
    compare,
    pairs,
)
from sensory_commutativity.studies.navigation.tables.navigation_curves import gather_curves
from sensory_commutativity.studies.navigation.tables.navigation_power import write_power
from sensory_commutativity.studies.navigation.tables.navigation_profiles import write_profiles
from sensory_commutativity.studies.navigation.tables.navigation_scores import (
    score_runs,
    write_scores,
)
from sensory_commutativity.studies.navigation.tables.navigation_summary import summarise
from sensory_commutativity.studies.navigation.tables.navigation_survival import write_survival

SPACES = ["full", "truncated", "adapted", "random-half", "inverse"]
SEEDS = [3, 1, 4, 15, 9, 2]
STEP = 2048
SPEED = {
    "full": 3,
    "truncated": 1,
    "adapted": 2,
    "random-half": 4,
    "inverse": 9,
}  # checkpoint at which it has learned


@pytest.fixture(scope="module")
def config():
    settings = load(DEFAULT)
    navigation = settings.navigation.model_copy(
        update=dict(
            action_spaces=SPACES,
            seeds=SEEDS,
            steps=5 * STEP,
            checkpoints=5,
            calibration_splits=50,
            evaluation_episodes=10,
        )
    )
    return settings.model_copy(update={"navigation": navigation})


@pytest.fixture(scope="module")
def curves(config) -> pd.DataFrame:
    """Six runs of five action spaces; a run has learned at its space's checkpoint, every third run one later."""
    rng, rows = np.random.default_rng(0), []
    for space in SPACES:
        for i, seed in enumerate(SEEDS):
            for k in range(1, 6):
                learned = k >= SPEED[space] + (i % 3 == 0)
                value = (40 if learned else 2) + rng.uniform(-1, 1)
                rows.append(
                    (space, seed, k * STEP, value, 0.92 if learned else 0.1, 0.05, 80.0, 10)
                )
    names = [
        "action_space",
        "seed",
        "step",
        "episode_return",
        "success_rate",
        "dead_rate",
        "episode_length",
        "episodes",
    ]
    return pd.DataFrame(rows, columns=names)


@pytest.fixture(scope="module")
def scores(curves, config) -> pd.DataFrame:
    return score_runs(curves.sample(frac=1, random_state=1), config)


@pytest.fixture(scope="module")
def comparisons(scores, config) -> pd.DataFrame:
    return compare(scores, config)


@pytest.fixture
def scores_file(scores, config, tmp_path):
    write_table("navigation_scores", scores, tmp_path / "scores.parquet", config)
    return tmp_path / "scores.parquet"


# ---- gathering -------------------------------------------------------------------------------------------------------------


def parts(curves, config, folder) -> list:
    paths = []
    for (space, seed), rows in curves.groupby(["action_space", "seed"]):
        paths.append(folder / f"{space}.{seed}.parquet")
        write_table("navigation_curves", rows, paths[-1], config)
    return paths


def test_gathered_curves_are_in_the_order_of_the_configuration(curves, config, tmp_path):
    gather_curves(parts(curves, config, tmp_path)[::-1], tmp_path / "out.parquet", config)
    table = read_table("navigation_curves", tmp_path / "out.parquet")
    assert len(table) == len(curves) and list(dict.fromkeys(table["action_space"])) == SPACES
    assert table[:5]["step"].tolist() == [k * STEP for k in range(1, 6)]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (
            lambda c: c[~((c["action_space"] == "adapted") & (c["seed"] == 15))],
            "1 of 30 training runs missing .adapted 15",
        ),
        (
            lambda c: c[c["action_space"] != "full"],
            "6 of 30 training runs missing .full 1, .* and 1 more",
        ),
        (
            lambda c: pd.concat([c, c[(c["action_space"] == "full") & (c["seed"] == 2)]]),
            "repeated .full 2",
        ),
        (lambda c: pd.concat([c, c[:5].assign(seed=77)]), "not asked for .full 77"),
        (lambda c: c.drop(index=c.index[7]), "incomplete, or evaluated after other steps .full 1"),
        (
            lambda c: c.assign(step=c["step"] + 1),
            "30 of 30 training runs incomplete, or evaluated after other steps",
        ),
        (
            lambda c: c.assign(episodes=np.where(c.index == 7, 9, 10)),
            "another number of episodes .full 1",
        ),
        (
            lambda c: c.assign(episode_return=np.where(c.index == 7, np.inf, 1.0)),
            "no numbers .full 1",
        ),
    ],
)
def test_missing_repeated_and_incomplete_runs_are_named_and_nothing_is_written(
    spoil, message, curves, config, tmp_path
):
    write_table("navigation_curves", spoil(curves), tmp_path / "part.parquet", config)
    with pytest.raises(TableError, match=message):
        gather_curves([tmp_path / "part.parquet"], tmp_path / "out.parquet", config)
    with pytest.raises(TableError, match=message):
        write_scores(tmp_path / "part.parquet", tmp_path / "out.parquet", config)
    assert not (tmp_path / "out.parquet").exists()


# ---- scores ----------------------------------------------------------------------------------------------------------------


def test_scores_by_hand(curves, scores, config):
    assert list(zip(scores["action_space"], scores["seed"], strict=True)) == config.navigation.runs
    run = curves[(curves["action_space"] == "adapted") & (curves["seed"] == 4)][
        "episode_return"
    ].to_numpy()
    row = scores[(scores["action_space"] == "adapted") & (scores["seed"] == 4)].iloc[0]
    assert row["final_return"] == run[-1] and row["auc"] == pytest.approx(run.sum() / 5)
    assert row["steps_to_threshold"] == 2 * STEP and row["reached"] and row["solved"]


def test_a_run_that_never_gets_there_is_censored_at_its_end(scores):
    inverse = scores[scores["action_space"] == "inverse"]
    assert not inverse["reached"].any() and not inverse["solved"].any()
    assert (inverse["steps_to_threshold"] == 5 * STEP).all()


def test_exactly_the_threshold_counts(curves, config):
    exact = curves.assign(
        episode_return=config.navigation.threshold_return,
        success_rate=config.navigation.solved_success_rate,
    )
    found = score_runs(exact, config)
    assert (
        found["reached"].all()
        and found["solved"].all()
        and (found["steps_to_threshold"] == STEP).all()
    )


def test_the_first_crossing_counts_even_if_the_run_falls_back(curves, config):
    up_and_down = curves.assign(episode_return=np.where(curves["step"] == 2 * STEP, 30.0, 0.0))
    found = score_runs(up_and_down, config)
    assert (found["steps_to_threshold"] == 2 * STEP).all() and found["reached"].all()


def test_the_summary_counts_runs(scores, config):
    table = summarise(scores, config).set_index(["action_space", "measure"])
    assert (
        table.loc[("full", "reached"), "mean"] == 1
        and table.loc[("inverse", "solved"), "mean"] == 0
    )
    assert table.loc[("full", "steps_to_threshold"), "mean"] == pytest.approx(
        (4 * 3 + 2 * 4) / 6 * STEP
    )
    assert table.loc[("full", "steps_to_threshold"), "median"] == 3 * STEP


# ---- comparisons -----------------------------------------------------------------------------------------------------------


def test_pairs_fall_into_two_families(config):
    found = pairs(config)
    assert [pair[1:] for pair in found if pair[0] == "paper"] == [
        ("truncated", "adapted"),
        ("truncated", "full"),
        ("adapted", "full"),
    ]
    assert len(found) == 10 and len({frozenset(pair[1:]) for pair in found}) == 10


def row(table, test, a, b, measure=STEPS):
    return table[
        (table["test"] == test)
        & (table["a"] == a)
        & (table["b"] == b)
        & (table["measure"] == measure)
    ].iloc[0]


def test_fewer_steps_are_a_negative_difference_and_better(comparisons):
    found = row(comparisons, WELCH, "truncated", "full")
    assert (
        found["difference"] == pytest.approx(-2 * STEP)
        and found["ci_low"] < -2 * STEP < found["ci_high"] < 0
        and found["effect_size"] < 0
    )
    assert row(comparisons, "Mann-Whitney", "truncated", "full")["effect_size"] == 1
    assert row(comparisons, "Mann-Whitney", "full", "inverse")["effect_size"] == 1
    assert row(comparisons, "Mann-Whitney", "truncated", "full", "auc")["effect_size"] == 1
    assert row(comparisons, LOG_RANK, "truncated", "full")["statistic"] > 0
    howell = row(comparisons, "Games-Howell", "truncated", "random-half")
    assert (
        howell["difference"] == pytest.approx(-3 * STEP)
        and howell["ci_low"] < howell["difference"] < howell["ci_high"]
    )


def test_half_the_steps(comparisons):
    found = row(comparisons, HALF, "truncated", "full")
    assert found["effect_size"] == pytest.approx((4 * 1 + 2 * 2) / (4 * 3 + 2 * 4))
    assert found["ci_low"] < found["effect_size"] < found["ci_high"]
    assert found["statistic"] < 0 and row(comparisons, HALF, "adapted", "full")["statistic"] > 0


def test_holm_is_over_the_pairs_of_a_family_for_each_measure_and_test(comparisons):
    corrected = comparisons[comparisons["test"] != "Games-Howell"]
    for (family, _, _), rows in corrected.groupby(["family", "measure", "test"]):
        assert len(rows) == (3 if family == "paper" else 7)
        assert rows["p_adjusted"].to_numpy() == pytest.approx(
            multipletests(rows["p"], method="holm")[1]
        )
    assert (corrected["p_adjusted"] > corrected["p"]).any()


def test_every_pair_has_every_test(comparisons):
    assert comparisons.groupby(["a", "b"]).size().tolist() == [4 * 4 + 3 + 2] * 10


def test_checkpoints_are_corrected_over_time_and_pairs(curves, config):
    table = compare_checkpoints(curves, config)
    assert len(table) == 5 * 10
    for family, rows in table.groupby("family"):
        assert len(rows) == 5 * (3 if family == "paper" else 7)
        assert rows["p_adjusted"].to_numpy() == pytest.approx(
            multipletests(rows["p"], method="holm")[1]
        )
    first = table[(table["a"] == "truncated") & (table["b"] == "full")].set_index("step")
    assert (
        first.loc[2 * STEP, "difference"] > 30
        and first.loc[2 * STEP, "p_adjusted"] < 1e-6
        and abs(first.loc[5 * STEP, "difference"]) < 2
    )


def test_survival_falls_to_the_censored(scores_file, config, tmp_path):
    write_survival(scores_file, tmp_path / "s.parquet", config)
    table = read_table("navigation_survival", tmp_path / "s.parquet")
    full = table[table["action_space"] == "full"]
    assert full["step"].tolist() == [0, 3 * STEP, 4 * STEP] and full[
        "survival"
    ].tolist() == pytest.approx([1, 1 / 3, 0])
    assert (table.loc[table["action_space"] == "inverse", "survival"] == 1).all()


def test_profiles_fall_from_one(scores_file, scores, config, tmp_path):
    write_profiles(scores_file, tmp_path / "p.parquet", config)
    table = read_table("navigation_profiles", tmp_path / "p.parquet")
    for space, rows in table.groupby("action_space"):
        returns = scores.loc[scores["action_space"] == space, "final_return"]
        assert rows["fraction"].is_monotonic_decreasing and rows["fraction"].iloc[0] == 1
        at = rows[np.isclose(rows["threshold"], 2.0)].iloc[0]
        assert at["fraction"] == (returns >= 2.0).mean()


def test_power_is_asked_at_two_levels_and_the_observed_effects_are_planning(
    scores_file, config, tmp_path
):
    write_power(scores_file, tmp_path / "p.parquet", config)
    table = read_table("navigation_power", tmp_path / "p.parquet")
    assert table["question"].value_counts().tolist() == [8, 3, 2]
    assert table["alpha"].round(4).isin([0.05, 0.0167]).all()


def test_calibration_counts_all_splits(scores_file, config, tmp_path):
    write_calibration(scores_file, tmp_path / "c.parquet", config)
    table = read_table("navigation_calibration", tmp_path / "c.parquet")
    for _, rows in table.groupby(["method", "measure"]):
        alone, together = (
            rows[rows["action_space"] != "all"],
            rows[rows["action_space"] == "all"].iloc[0],
        )
        assert alone["rejected"].sum() == together["rejected"] and (alone["splits"] == 10).all()


# ---- settings --------------------------------------------------------------------------------------------------------------


def spoil(settings: dict, **changes) -> dict:
    settings["navigation"].update(changes)
    return settings


ZONE = {"x": 120.0, "y": 120.0, "radius": 50.0, "reward": 50.0}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seeds": [0, 1, 2, 2]}, r"seeds holds 2 more than once"),
        ({"seeds": [0, 1, 2]}, "navigation.seeds"),
        ({"seeds": [0, 1, 2, -1]}, "navigation.seeds"),
        ({"action_spaces": ["full", "truncated", "inverse"]}, "action_spaces lacks adapted"),
        (
            {"action_spaces": ["full", "truncated", "adapted", "full"]},
            "action_spaces holds full more than once",
        ),
        ({"action_spaces": ["full", "truncated", "adapted", "short"]}, "navigation.action_spaces"),
        ({"steps": 40_961}, "steps 40961 is no multiple of 10240 .* set it to 40960"),
        ({"zones": [{**ZONE, "reward": -20.0}]}, "zones holds no goal"),
        ({"zones": [ZONE, {**ZONE, "x": 200.0}]}, "overlaps"),
        ({"zones": [{**ZONE, "x": 20.0}]}, "leaves the room"),
        ({"zones": [{**ZONE, "y": 580.0}]}, "leaves the room"),
        ({"threshold_return": 51.0}, "threshold_return 51 is more than the best reward 50"),
        ({"learner": {"batch_size": 500}}, "batch_size 500"),
        ({"learner": {"batch_size": 192}}, "batch_size 192"),
        ({"world": "nowhere"}, "navigation.world names 'nowhere'"),
        ({"agent": "nobody"}, "navigation.agent names 'nobody'"),
        ({"scp_world": "nowhere"}, "navigation.scp_world names 'nowhere'"),
        ({"agent": "long-arms"}, "needs the SCP of 'long-arms' in 'furnished'.*flatland.variants"),
    ],
)
def test_bad_settings_are_refused_with_key_and_remedy(changes, message, default_settings):
    with pytest.raises(ConfigError, match=message):
        validate(spoil(default_settings, **changes))


def test_zones_that_leave_no_place_to_start_are_refused(default_settings):
    corners = [
        {"x": x, "y": y, "radius": 150.0, "reward": 50.0}
        for x in (150.0, 450.0)
        for y in (150.0, 450.0)
    ]
    zones = [*corners, {"x": 300.0, "y": 300.0, "radius": 60.0, "reward": -1.0}]
    with pytest.raises(ConfigError, match=r"navigation\.zones"):
        check_navigation(validate(spoil(default_settings, zones=zones)))


def test_all_profiles_agree_with_the_checks():
    for profile in ("paper", "test"):
        check_navigation(load(DEFAULT, ROOT / "config" / f"{profile}.yaml"))
    paper = load(DEFAULT, ROOT / "config" / "paper.yaml").navigation
    assert len(paper.seeds) == 60 and len(paper.runs) == 300


@pytest.mark.parametrize(
    "arguments",
    [["--action-space", "short", "--seed", "0"], ["--action-space", "full", "--seed", "7"]],
)
def test_an_unknown_run_is_refused_before_it_begins(arguments, tmp_path):
    files = [
        "--navigation-scp",
        "none.parquet",
        "--model",
        str(tmp_path / "m.pt"),
        "--out",
        str(tmp_path / "o.parquet"),
    ]
    found = CliRunner().invoke(
        main, ["navigation-run", "--config", str(DEFAULT), *arguments, *files]
    )
    assert found.exit_code == 2 and "full, truncated, adapted" in found.output
    assert not list(tmp_path.iterdir())
