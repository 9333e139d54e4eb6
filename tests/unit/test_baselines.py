"""baselines/: naive change and prediction error, on transitions made by hand and on played ones."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from sensory_commutativity.studies.flatland.config import BaselinesConfig
from sensory_commutativity.studies.flatland.naive_change import (
    mean_and_standard_error,
    squared_change,
)
from sensory_commutativity.studies.flatland.prediction import make_network, prediction_error
from sensory_commutativity.studies.flatland.transitions import Transitions, collect_transitions
from tests.helpers import DOFS, update_flatland

LENGTH, PIXELS = 5, 4


def settings(
    transitions: int = 100, training: int = 50, epochs: int = 5, **other
) -> BaselinesConfig:
    return BaselinesConfig(
        transitions=transitions,
        training=training,
        epochs=epochs,
        **{"batch_size": 16, "learning_rate": 1e-3, **other},
    )


def random_transitions(sequences: int = 20, seed: int = 0) -> Transitions:
    rng = np.random.default_rng(seed)
    observations = rng.integers(0, 256, (sequences, LENGTH + 1, PIXELS, 3)).astype(np.uint8)
    return Transitions(observations, rng.uniform(-1, 1, (sequences, LENGTH, 8)).astype(np.float32))


# ---- naive change ----------------------------------------------------------------------------------------------------------


def test_squared_change_by_hand():
    observations = np.zeros((2, 3, 1, 3), np.uint8)
    observations[0, :, 0] = [
        (0, 0, 0),
        (1, 0, 2),
        (1, 0, 0),
    ]  # squares 1 0 4, then 0 0 4: mean 9 / 6
    observations[1, :, 0] = [
        (0, 0, 0),
        (255, 255, 255),
        (0, 0, 0),
    ]  # up and down, and no wrapping of bytes
    assert squared_change(Transitions(observations, np.zeros((2, 2, 8), np.float32))).tolist() == [
        1.5,
        255.0**2,
    ]


def test_no_change():
    observations = np.full((3, 6, 4, 3), 77, np.uint8)
    assert squared_change(Transitions(observations, np.zeros((3, 5, 8), np.float32))).tolist() == [
        0,
        0,
        0,
    ]


def test_mean_and_standard_error_by_hand():
    mean, error = mean_and_standard_error(np.array([1.0, 2.0, 3.0, 6.0]))
    assert mean == 3
    assert error == pytest.approx(np.sqrt(14 / 3) / 2)
    assert isinstance(mean, float) and isinstance(error, float)


def test_the_standard_error_covers():
    rng = np.random.default_rng(3)
    inside = 0
    for _ in range(500):
        mean, error = mean_and_standard_error(rng.normal(10, 2, 60))
        inside += abs(mean - 10) < 2.0 * error
    assert 0.92 < inside / 500 < 0.98


# ---- prediction error ------------------------------------------------------------------------------------------------------


def test_the_network_is_the_paper_s():
    """Two hidden layers with as many neurons as inputs (appendix A)."""
    layers = [layer for layer in make_network(200, 192) if isinstance(layer, torch.nn.Linear)]
    assert [(layer.in_features, layer.out_features) for layer in layers] == [
        (200, 200),
        (200, 200),
        (200, 192),
    ]


def test_equal_seeds_give_equal_errors():
    transitions = random_transitions()
    first, again, other = (prediction_error(transitions, settings(), seed) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    torch.rand(100)
    before = torch.get_rng_state()
    assert np.array_equal(first, prediction_error(transitions, settings(), 1))
    assert torch.equal(
        torch.get_rng_state(), before
    )  # the global generator is neither used nor update_flatland


@pytest.mark.parametrize(("training", "tested"), [(50, 10), (75, 5), (95, 1)])
def test_the_rest_is_tested_sequence_by_sequence(training, tested):
    errors = prediction_error(random_transitions(), settings(training=training, epochs=1), 0)
    assert errors.shape == (tested,)
    assert errors.dtype == np.float64
    assert (errors > 0).all()


def test_test_sequences_do_not_teach():
    """Another test sequence changes its own error and no other."""
    transitions = random_transitions()
    before = prediction_error(transitions, settings(), 3)
    observations = transitions.observations.copy()
    observations[-1] = 255 - observations[-1]
    after = prediction_error(Transitions(observations, transitions.actions), settings(), 3)
    assert np.array_equal(before[:-1], after[:-1])
    assert before[-1] != after[-1]


def test_training_sequences_do_teach():
    transitions = random_transitions()
    before = prediction_error(transitions, settings(), 3)
    observations = transitions.observations.copy()
    observations[9] = 255 - observations[9]  # the last one of the training set
    after = prediction_error(Transitions(observations, transitions.actions), settings(), 3)
    assert (before != after).all()


def test_what_never_changes_is_foreseen():
    observations = np.broadcast_to(
        np.arange(12, dtype=np.uint8).reshape(PIXELS, 3) * 20, (40, LENGTH + 1, PIXELS, 3)
    ).copy()
    constant = Transitions(observations, random_transitions(40).actions)
    errors = prediction_error(constant, settings(200, 150, epochs=150, learning_rate=3e-3), 0)
    assert errors.max() < 30  # of 255 squared: about five levels
    unforeseeable = prediction_error(random_transitions(40), settings(200, 150, epochs=20), 0)
    assert unforeseeable.min() > 1000


def test_what_the_action_decides_is_foreseen():
    """The next view is bright or dark as the action says; a network that did not see the action would be wrong by 100 levels."""
    rng = np.random.default_rng(0)
    actions = np.zeros((80, LENGTH, 8), np.float32)
    actions[:, :, 0] = np.sign(rng.uniform(-1, 1, (80, LENGTH)))
    observations = np.full((80, LENGTH + 1, PIXELS, 3), 127, np.uint8)
    observations[:, 1:] = np.where(actions[:, :, 0] > 0, 227, 27)[:, :, None, None]
    errors = prediction_error(
        Transitions(observations, actions), settings(400, 300, epochs=60, learning_rate=3e-3), 0
    )
    assert errors.max() < 1000 < 100**2


def test_the_error_is_in_squared_levels():
    """Before it has learnt anything a network predicts about 0: wrong by all that there is to see."""
    observations = np.full((20, LENGTH + 1, PIXELS, 3), 200, np.uint8)
    errors = prediction_error(
        Transitions(observations, np.zeros((20, LENGTH, 8), np.float32)),
        settings(epochs=1, learning_rate=1e-9),
        0,
    )
    assert errors == pytest.approx(np.full(10, 200.0**2), rel=0.4)


# ---- transitions -----------------------------------------------------------------------------------------------------------


def test_transitions_are_what_was_played(tiny_config):
    transitions = collect_transitions(tiny_config, "left-shoulder")
    assert transitions.observations.shape == (25, 5, 64, 3)
    assert transitions.actions.shape == (25, 4, 8)
    k = DOFS.index("left-shoulder")
    assert not np.delete(transitions.actions, k, axis=2).any()
    assert transitions.actions[:, :, k].all()
    assert np.abs(transitions.actions).max() <= 1
    again = collect_transitions(tiny_config, "left-shoulder")
    assert np.array_equal(transitions.observations, again.observations)
    assert np.array_equal(transitions.actions, again.actions)


def test_all_dofs_share_their_start_situations(tiny_config):
    head, eyelid = (collect_transitions(tiny_config, dof) for dof in ("head", "eyelid"))
    assert np.array_equal(head.observations[:, 0], eyelid.observations[:, 0])
    assert not np.array_equal(head.observations[:, 1:], eyelid.observations[:, 1:])
    assert not np.array_equal(head.actions[:, :, 2], eyelid.actions[:, :, 3])
    assert len(np.unique(head.observations[:, 0].reshape(25, -1), axis=0)) == 25


def test_more_transitions_begin_with_the_same(tiny_config):
    few = collect_transitions(tiny_config, "head")
    many = collect_transitions(update_flatland(tiny_config, baselines={"transitions": 200}), "head")
    assert np.array_equal(many.observations[:25], few.observations)


def test_transitions_come_from_the_reference_world(tiny_config):
    transitions = collect_transitions(
        update_flatland(tiny_config, reference={"world": "things-8", "agent": "slow-base"}),
        "base-longitudinal",
    )
    other = collect_transitions(tiny_config, "base-longitudinal")
    assert not np.array_equal(transitions.observations[:, 0], other.observations[:, 0])


def test_the_action_leads_from_one_observation_to_the_next(tiny_config):
    """The eyelid in a bare room: every pixel follows it."""
    bare = update_flatland(
        tiny_config, worlds={"bare": {"objects": 0}}, reference={"world": "bare"}
    )
    transitions = collect_transitions(bare, "eyelid")
    opened = 1 + 0.05 * np.cumsum(transitions.actions[:, :, 3], axis=1)  # authors: 1/20 per step
    expected = np.minimum(255, transitions.observations[:, :1] * opened[:, :, None, None])
    assert (
        np.abs(transitions.observations[:, 1:] - expected).max() <= 0.51
    )  # rounded to whole levels
    assert (transitions.observations[:, 1:] != transitions.observations[:, :1]).any()
