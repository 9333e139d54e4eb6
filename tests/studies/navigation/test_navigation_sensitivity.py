"""The comparison of the steps at other thresholds, and by the seeds of the confirmation."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.navigation.tables.navigation_sensitivity import (
    navigation_sensitivity,
    steps_to,
)
from tests.studies.examples import overlay, write_frame

SEEDS = list(range(8))


@pytest.fixture(scope="module")
def config(default_config) -> Config:
    return overlay(default_config, navigation={"seeds": SEEDS, "confirmation_seeds": 4})


def make_curves(config: Config, first: dict[str, int]) -> pd.DataFrame:
    """Curves that reach the best return at checkpoint `first` of each action space, and seed."""
    navigation = config.navigation
    steps = navigation.steps // navigation.checkpoints * np.arange(1, navigation.checkpoints + 1)
    rows = [
        (space, seed, step, 50.0 if k >= first.get(space, 99) + seed % 2 else 0.0, 0.5, 0.0, 9.0,
         navigation.evaluation_episodes)
        for space, seed in navigation.runs
        for k, step in enumerate(steps)
    ]  # fmt: skip
    columns = ["action_space", "seed", "step", "episode_return", "success_rate", "dead_rate",
               "episode_length", "episodes"]  # fmt: skip
    return pd.DataFrame(rows, columns=columns)


def test_every_threshold_set_of_runs_and_pair_has_a_row(config, tmp_path):
    curves = make_curves(config, {"truncated": 0, "adapted": 0, "full": 2})
    table = navigation_sensitivity(curves, config)
    assert len(table) == 3 * 4 * 3
    write_frame(navigation_sensitivity, config, tmp_path, table)
    twice = table[(table["a"] == "truncated") & (table["b"] == "full")].set_index(
        ["runs", "threshold"]
    )
    assert twice["n"].loc["all"].tolist() == [8] * 4
    assert twice["n"].loc["confirmation"].tolist() == [4] * 4
    assert (twice["ratio"] < 1).all() and (twice["censored_a"] == 0).all()


def test_runs_that_never_reach_a_threshold_are_censored_at_their_end(config, tmp_path):
    table = navigation_sensitivity(make_curves(config, {}), config)
    assert (table["censored_a"] == table["n"]).all() and (table["ratio"] == 1).all()
    assert (table["mean_b"] == config.navigation.steps).all()
    write_frame(navigation_sensitivity, config, tmp_path, table)  # no value is missing


def test_steps_are_those_before_the_first_evaluation_with_the_return(config):
    curves = make_curves(config, {"full": 1})
    steps, reached = steps_to(curves, "full", [0, 1], 25.0, config.navigation.steps)
    segment = config.navigation.steps // config.navigation.checkpoints
    assert steps.tolist() == [2 * segment, 3 * segment] and reached.all()


def test_few_seeds_cannot_confirm(default_config):
    for n in (1, 3, 6):
        with pytest.raises(ConfigError, match="confirmation_seeds"):
            overlay(default_config, navigation={"seeds": SEEDS, "confirmation_seeds": n})
