"""SC-experiments and commutation experiments in Flatland: what is played, with which seeds."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.scp.distances import mean_squared_error
from sensory_commutativity.scp.experiment import commutation_experiment, compare_orders
from sensory_commutativity.scp.sequences import permute, sample_sequence
from sensory_commutativity.seeding import generator, seed_for
from sensory_commutativity.studies.flatland.builders import experiment_runs, flatland_world
from sensory_commutativity.studies.flatland.tables.flatland_commutation_experiments import (
    flatland_commutation_experiments,
)
from sensory_commutativity.studies.flatland.tables.flatland_experiments import flatland_experiments
from tests.helpers import DOFS, update_flatland

RUN = "furnished.polyphemus.40"


def play(config, run: str = RUN, start: int = 0, stop: int = 6) -> pd.DataFrame:
    return flatland_experiments(config, run).compute(start, stop)


def play_pairs(config, world: str = "furnished", start: int = 0, stop: int = 3) -> pd.DataFrame:
    return flatland_commutation_experiments(config, world).compute(start, stop)


@pytest.fixture(scope="module")
def config(tiny_config):
    """Sequences so long that some experiments do not commute."""
    baselines = dict(transitions=120, training=80)
    return update_flatland(tiny_config, sequence_length=40, baselines=baselines)


@pytest.fixture(scope="module")
def experiments(config) -> pd.DataFrame:
    return play(config)


def test_every_dof_is_tried_in_every_start_situation(experiments):
    assert experiments.columns.tolist() == flatland_experiments.column_names
    assert experiments["dof"].tolist() == DOFS * 6
    assert experiments["experiment"].tolist() == np.repeat(np.arange(6), 8).tolist()
    runs = experiments[["world", "agent", "length"]].drop_duplicates().values.tolist()
    assert runs == [["furnished", "polyphemus", 40]]
    assert experiments.groupby("experiment")["seed"].nunique().eq(1).all()
    assert experiments["seed"].nunique() == 6
    assert (experiments["distance"] >= 0).all() and (experiments["distance"] > 0).any()


def test_an_experiment_is_what_definition_3_says(experiments, config):
    """An experiment that does not commute, played step by step."""
    row = experiments[experiments["distance"] > 0].iloc[-1]
    seed = seed_for(config.seed, "flatland", "furnished", "polyphemus", row["experiment"])
    world = flatland_world(config.flatland, "furnished", "polyphemus")
    world.reset(generator(seed, "situation"))
    rng = generator(seed, "sequence", row["dof"])
    sequence = sample_sequence(rng, 40, DOFS.index(row["dof"]), 8)
    ends = compare_orders(world, world.snapshot(), sequence, permute(rng, sequence), 3)
    assert (row["seed"], row["distance"]) == (seed, mean_squared_error(*ends))


def test_start_situations_belong_to_the_seed_the_world_and_the_agent(experiments, config):
    other_length = play(config, "furnished.polyphemus.6")
    assert other_length["seed"].tolist() == experiments["seed"].tolist()
    for other, run in (
        (config, "things-8.polyphemus.40"),
        (config, "furnished.slow-base.40"),
        (config.model_copy(update={"seed": 1}), RUN),
    ):
        assert not set(play(other, run, stop=2)["seed"]) & set(experiments["seed"])
    extended = update_flatland(
        config, worlds={"attic": {"objects": 2}}, agents={"giraffe": {"arm_length": 100.0}}
    )
    pd.testing.assert_frame_equal(play(extended), experiments)


@pytest.fixture(scope="module")
def pairs(tiny_config) -> pd.DataFrame:
    return play_pairs(tiny_config)


def test_every_unordered_pair_is_tried_once(pairs):
    assert pairs.columns.tolist() == flatland_commutation_experiments.column_names
    tried = [frozenset(pair) for pair in zip(pairs["dof_a"], pairs["dof_b"], strict=True)]
    assert len(set(tried)) == 36
    assert all(tried.count(pair) == 3 for pair in set(tried))


def test_a_commutation_experiment_step_by_step(tiny_config):
    for world, rest_steps in (("furnished", 3), ("settled", 5)):
        frame = play_pairs(tiny_config, world, 2, 3).set_index(["dof_a", "dof_b"])
        row = frame.loc[("base-longitudinal", "base-rotation")]
        seed = seed_for(tiny_config.seed, "commutation", world, "polyphemus", 2)
        room = flatland_world(tiny_config.flatland, world, "polyphemus")
        room.reset(generator(seed, "situation"))
        h, g = (sample_sequence(generator(seed, "first", DOFS[k]), 4, k, 8) for k in (0, 1))
        ends = commutation_experiment(room, room.snapshot(), h, g, rest_steps)
        assert row["world"] == world and row["seed"] == seed
        assert row["distance"] == mean_squared_error(*ends) > 0


def test_a_dof_is_tried_against_another_sequence_of_its_own(tiny_config):
    """Against itself everything would commute.

    In a small room, obstacles now and then stop the base in one order only.
    """
    config = update_flatland(
        tiny_config,
        sequence_length=60,
        worlds={"furnished": {"width": 320.0, "height": 320.0, "objects": 4}},
        baselines=dict(transitions=120, training=60),
    )
    frame = play_pairs(config, stop=12)
    base = frame[(frame["dof_a"] == DOFS[0]) & (frame["dof_b"] == DOFS[0])]
    assert len(base) == 12 and (base["distance"] > 0).any()


def test_runs_are_named_after_world_agent_and_length(default_config):
    runs = experiment_runs(default_config)
    assert next(iter(runs)) == "furnished.polyphemus.50" and len(runs) == 18
    assert runs["things-12.long-arms.50"] == ("things-12", "long-arms", 50, 300)
