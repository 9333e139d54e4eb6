"""The paper's alternatives to the SCP: naive change and prediction error."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.studies import runner
from sensory_commutativity.studies.flatland.config import BaselinesConfig
from sensory_commutativity.studies.flatland.naive_change import (
    mean_and_standard_error,
    squared_change,
)
from sensory_commutativity.studies.flatland.prediction import make_network, prediction_error
from sensory_commutativity.studies.flatland.tables.flatland_baselines import flatland_baselines
from sensory_commutativity.studies.flatland.transitions import Transitions, collect_transitions
from tests.helpers import DOFS, update_flatland
from tests.studies.examples import write_shards

LENGTH, PIXELS = 5, 4


def settings(
    transitions: int = 100, training: int = 50, epochs: int = 5, **other
) -> BaselinesConfig:
    more = {"batch_size": 16, "learning_rate": 1e-3, **other}
    return BaselinesConfig(transitions=transitions, training=training, epochs=epochs, **more)


def random_transitions(sequences: int = 20) -> Transitions:
    rng = np.random.default_rng(0)
    observations = rng.integers(0, 256, (sequences, LENGTH + 1, PIXELS, 3)).astype(np.uint8)
    return Transitions(observations, rng.uniform(-1, 1, (sequences, LENGTH, 8)).astype(np.float32))


# ---- naive change -----------------------------------------------------------------------------


def test_squared_change_by_hand():
    observations = np.zeros((3, 3, 1, 3), np.uint8)
    observations[0, :, 0] = [(0, 0, 0), (1, 0, 2), (1, 0, 0)]  # squares 1 0 4 and 0 0 4
    observations[1, :, 0] = [(0, 0, 0), (255, 255, 255), (0, 0, 0)]  # bytes must not wrap
    observations[2] = 77
    transitions = Transitions(observations, np.zeros((3, 2, 8), np.float32))
    assert squared_change(transitions).tolist() == [1.5, 255.0**2, 0.0]


def test_the_standard_error_by_hand_and_its_coverage():
    mean, error = mean_and_standard_error(np.array([1.0, 2.0, 3.0, 6.0]))
    assert (mean, error) == (3, pytest.approx(np.sqrt(14 / 3) / 2))
    rng, covered = np.random.default_rng(3), 0
    for _ in range(500):
        mean, error = mean_and_standard_error(rng.normal(10, 2, 60))
        covered += abs(mean - 10) < 2.0 * error
    assert 0.92 < covered / 500 < 0.98


# ---- prediction error -------------------------------------------------------------------------


def test_the_network_has_two_hidden_layers_as_wide_as_its_input():
    """Paper, appendix A."""
    layers = [layer for layer in make_network(200, 192) if isinstance(layer, torch.nn.Linear)]
    sizes = [(layer.in_features, layer.out_features) for layer in layers]
    assert sizes == [(200, 200), (200, 200), (200, 192)]


def test_errors_depend_on_the_seed_and_not_on_the_global_generator():
    transitions = random_transitions()
    first, again, other = (prediction_error(transitions, settings(), seed) for seed in (1, 1, 2))
    assert np.array_equal(first, again) and not np.array_equal(first, other)
    torch.rand(100)
    before = torch.get_rng_state()
    assert np.array_equal(first, prediction_error(transitions, settings(), 1))
    assert torch.equal(torch.get_rng_state(), before)


def test_the_first_sequences_train_and_the_others_test():
    transitions = random_transitions()
    for training, tested in ((50, 10), (75, 5), (95, 1)):
        errors = prediction_error(transitions, settings(training=training, epochs=1), 0)
        assert errors.shape == (tested,) and errors.dtype == np.float64 and (errors > 0).all()
    before = prediction_error(transitions, settings(), 3)
    for sequence, changed in ((-1, [False] * 9 + [True]), (9, [True] * 10)):
        observations = transitions.observations.copy()
        observations[sequence] = 255 - observations[sequence]
        after = prediction_error(Transitions(observations, transitions.actions), settings(), 3)
        assert (before != after).tolist() == changed


def test_what_never_changes_and_what_the_action_decides_is_predicted():
    actions = random_transitions(40).actions
    image = np.arange(12, dtype=np.uint8).reshape(PIXELS, 3) * 20
    constant = Transitions(np.tile(image, (40, LENGTH + 1, 1, 1)), actions)
    errors = prediction_error(constant, settings(200, 150, epochs=150, learning_rate=3e-3), 0)
    assert errors.max() < 30  # of 255 squared: about five levels
    noise = prediction_error(random_transitions(40), settings(200, 150, epochs=20), 0)
    assert noise.min() > 1000
    # The next view is bright or dark, as the action says: without it the error is 100 levels.
    rng = np.random.default_rng(0)
    actions = np.zeros((80, LENGTH, 8), np.float32)
    actions[:, :, 0] = np.sign(rng.uniform(-1, 1, (80, LENGTH)))
    observations = np.full((80, LENGTH + 1, PIXELS, 3), 127, np.uint8)
    observations[:, 1:] = np.where(actions[:, :, 0] > 0, 227, 27)[:, :, None, None]
    decided = Transitions(observations, actions)
    errors = prediction_error(decided, settings(400, 300, epochs=60, learning_rate=3e-3), 0)
    assert errors.max() < 1000 < 100**2


def test_errors_are_in_squared_levels():
    """An untrained network predicts about 0, so its error is that of the whole picture."""
    observations = np.full((20, LENGTH + 1, PIXELS, 3), 200, np.uint8)
    bright = Transitions(observations, np.zeros((20, LENGTH, 8), np.float32))
    errors = prediction_error(bright, settings(epochs=1, learning_rate=1e-9), 0)
    assert errors == pytest.approx(np.full(10, 200.0**2), rel=0.4)


# ---- transitions ------------------------------------------------------------------------------


def test_only_the_chosen_dof_acts_and_the_same_is_played_again(tiny_config):
    transitions = collect_transitions(tiny_config, "left-shoulder")
    assert transitions.observations.shape == (25, 5, 64, 3)
    assert transitions.actions.shape == (25, 4, 8)
    k = DOFS.index("left-shoulder")
    assert not np.delete(transitions.actions, k, axis=2).any()
    assert transitions.actions[:, :, k].all() and np.abs(transitions.actions).max() <= 1
    again = collect_transitions(tiny_config, "left-shoulder")
    assert np.array_equal(transitions.observations, again.observations)
    assert np.array_equal(transitions.actions, again.actions)


def test_all_dofs_share_the_start_situations_of_the_reference_world(tiny_config):
    head, eyelid = (collect_transitions(tiny_config, dof) for dof in ("head", "eyelid"))
    starts = head.observations[:, 0]
    assert np.array_equal(starts, eyelid.observations[:, 0])
    assert not np.array_equal(head.observations[:, 1:], eyelid.observations[:, 1:])
    assert not np.array_equal(head.actions[:, :, 2], eyelid.actions[:, :, 3])
    assert len(np.unique(starts.reshape(25, -1), axis=0)) == 25
    longer = update_flatland(tiny_config, baselines={"transitions": 200})
    more = collect_transitions(longer, "head")
    assert np.array_equal(more.observations[:25], head.observations)
    elsewhere = update_flatland(tiny_config, reference={"world": "things-8", "agent": "slow-base"})
    assert not np.array_equal(collect_transitions(elsewhere, "head").observations[:, 0], starts)


def test_the_action_leads_from_one_observation_to_the_next(tiny_config):
    """The eyelid in an empty room: every pixel follows it."""
    bare = update_flatland(
        tiny_config, worlds={"bare": {"objects": 0}}, reference={"world": "bare"}
    )
    transitions = collect_transitions(bare, "eyelid")
    before, after = transitions.observations[:, :1], transitions.observations[:, 1:]
    opened = 1 + 0.05 * np.cumsum(transitions.actions[:, :, 3], axis=1)  # authors: 1/20 per step
    expected = np.minimum(255, before * opened[:, :, None, None])
    assert np.abs(after - expected).max() <= 0.51  # rounded to whole levels
    assert (after != before).any()


# ---- the table --------------------------------------------------------------------------------


def test_a_dof_is_measured_alone_and_the_excess_when_all_are(tiny_config, tmp_path):
    (path,) = write_shards(flatland_baselines, tiny_config, tmp_path, "head")
    first = path.read_bytes()
    write_shards(flatland_baselines, tiny_config, tmp_path, "head")
    assert path.read_bytes() == first
    table, _ = runner.read_shards(flatland_baselines, tiny_config, [path])
    (row,) = table.itertuples()
    assert (row.dof, row.n_transitions, row.n_test) == ("head", 100, 48)
    assert np.isnan(row.excess_error)
    assert min(row.naive_mse, row.naive_se, row.prediction_mse, row.prediction_se) > 0
    paths = [path]
    for dof in DOFS:
        if dof != "head":
            paths += write_shards(flatland_baselines, tiny_config, tmp_path, dof)
    out = tmp_path / "flatland_baselines.parquet"
    runner.write_product(flatland_baselines, tiny_config, paths, out)
    table = runner.read_product(flatland_baselines, tiny_config, out)
    assert table["dof"].tolist() == DOFS
    assert table["excess_error"].min() == 0 and table["excess_error"].notna().all()
