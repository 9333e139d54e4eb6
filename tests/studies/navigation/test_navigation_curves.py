"""Learning curves are gathered completely, and scored."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.errors import TableError, UserError
from sensory_commutativity.studies import registry, runner
from sensory_commutativity.studies.loading import merge, validate
from sensory_commutativity.studies.navigation.runs import TRAINING
from sensory_commutativity.studies.navigation.tables.navigation_checkpoints import (
    navigation_checkpoints,
)
from sensory_commutativity.studies.navigation.tables.navigation_curves import navigation_curves
from sensory_commutativity.studies.navigation.tables.navigation_scores import navigation_scores
from tests.studies.navigation.examples import SEEDS, SPACES, STEP, make_curves, with_spaces


def test_gathered_curves_are_sorted_and_complete(curves, five_spaces, tmp_path):
    config, paths = five_spaces, []
    for (space, seed), rows in curves.groupby(["action_space", "seed"]):
        run = f"{space}.{seed}"
        paths.append(tmp_path / f"{run}.parquet")
        runner.write_shard(navigation_curves, config, run, rows, paths[-1])
    out = tmp_path / "navigation_curves.parquet"
    runner.write_product(navigation_curves, config, paths, out)
    table = runner.read_product(navigation_curves, config, out)
    runs = table[["action_space", "seed"]].drop_duplicates().values.tolist()
    assert runs == [[space, seed] for space in SPACES for seed in sorted(SEEDS)]
    assert table["step"].tolist() == [k * STEP for k in range(1, 6)] * 30
    merged = table.merge(curves)
    assert len(merged) == len(table)
    out.unlink()
    for given, message in (
        (paths[1:], "needs the input adapted.1.parquet"),
        ([*paths, paths[0]], "adapted.1.parquet: given twice"),
        ([*paths, tmp_path / "full.77.parquet"], "full.77.parquet: is no input"),
    ):
        with pytest.raises(UserError, match=message):
            runner.write_product(navigation_curves, config, given, out)
    rows = curves[(curves["action_space"] == "full") & (curves["seed"] == 1)]
    runner.write_shard(navigation_curves, config, "full.2", rows, tmp_path / "full.2.parquet")
    with pytest.raises(TableError, match="missing: action_space full, seed 2, step 2048"):
        runner.write_product(navigation_curves, config, paths, out)
    assert not out.exists()


def test_incomplete_runs_are_refused(curves, five_spaces):
    last, adapted = curves.index[-1], curves["action_space"] == "adapted"
    for frame, message in (
        (curves[~(adapted & (curves["seed"] == 15))],
         "5 of 150 groups of rows missing: action_space adapted, seed 15, step 2048 and 4 more"),
        (curves[curves["action_space"] != "full"], "30 of 150 groups of rows missing"),
        (curves.drop(index=last), "1 of 150 .* missing: action_space inverse, seed 2, step 10240"),
        (curves.assign(step=curves["step"] + 1), "150 of 150 groups of rows missing"),
        (pd.concat([curves, curves[:5].assign(seed=77)]), "5 of .* not part of the configuration"),
        (pd.concat([curves, curves[:1]]), "1 of 150 groups of rows incomplete"),
    ):  # fmt: skip
        with pytest.raises(TableError, match=message):
            runner.check_complete(frame, navigation_curves, five_spaces, Path("curves"))
    for compute in (navigation_scores, navigation_checkpoints):
        for changes, message in (
            (dict(episodes=np.where(curves.index == 7, 9, 10)), r"1 of 30 .* not .* 10 episodes"),
            (dict(episode_return=np.where(curves.index < 30, np.inf, 1.0)),
             r"6 of 30 training runs .* not finite \(full.1, .* and 1 more\)"),
        ):  # fmt: skip
            with pytest.raises(TableError, match=message):
                compute(curves.assign(**changes), five_spaces)


def test_curves_are_written_by_training_only(five_spaces):
    with pytest.raises(UserError, match=r"train navigation_policy --run full\.1"):
        navigation_curves(None, five_spaces, "full.1")
    with pytest.raises(UserError, match=r"no run 'short\.1'"):
        TRAINING.of_run(five_spaces, "short.1")


def test_a_run_depends_on_its_own_settings_and_the_measured_scp_alone(five_spaces):
    def digest(**sections) -> str:
        config = validate(merge(five_spaces.model_dump(mode="json"), sections))
        return registry.settings_digest(registry.find_input("navigation_policy")[0], config,
                                        "full.1")  # fmt: skip

    for changes in (
        {"navigation": {"seeds": [*SEEDS, 77]}},
        {"navigation": {"action_spaces": SPACES[:3], "alpha": 0.01}},
        {"navigation": {"threshold_return": 3.0, "calibration_splits": 99}},
        {"flatland": {"experiments_per_job": 17, "thresholds": [0.0, 5.0]}},
        {"flatland": {"agents": {"long-arms": {"arm_length": 99.0}}}},
    ):
        assert digest(**changes) == digest(), changes
    for changes in (
        {"navigation": {"max_episode_steps": 99}},
        {"navigation": {"learner": {"epochs": 3}}},
        {"flatland": {"worlds": {"furnished": {"objects": 3}}}},
        {"flatland": {"agents": {"sprinter": {"arm_length": 45.0}}}},
        {"seed": 5},
    ):
        assert digest(**changes) != digest(), changes


def test_scores_of_a_run_by_hand(default_config):
    config = with_spaces(default_config, SPACES[:3], threshold_return=10.0, solved_success_rate=0.5)

    def score(values: list[float]) -> pd.DataFrame:
        curves = make_curves(config, lambda space, i, k: values[k - 1])
        return navigation_scores(curves.sample(frac=1, random_state=2), config)

    scores = score([0.0, 12.0, 9.0, 10.0, 8.0])  # falls below the threshold again
    runs = list(zip(scores["action_space"], scores["seed"], strict=True))
    assert runs == config.navigation.runs and len(runs) == 18
    for row in scores.itertuples():
        assert (row.final_return, row.auc, row.success_rate) == (8.0, pytest.approx(39 / 5), 0.5)
        assert (row.steps_to_threshold, row.reached, row.solved) == (2 * STEP, True, True)
    late = score([9.99, 9.99, 9.99, 9.99, 10.0])  # exactly the threshold counts
    assert late["reached"].all() and (late["steps_to_threshold"] == 5 * STEP).all()
    never = score([9.99] * 5)  # censored at the end of the run
    assert not never["reached"].any() and (never["steps_to_threshold"] == 5 * STEP).all()
    unsolved = with_spaces(default_config, SPACES[:3], solved_success_rate=0.51)
    assert not navigation_scores(make_curves(config, lambda *_: 50.0), unsolved)["solved"].any()
