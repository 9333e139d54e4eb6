"""scp/experiment.py: two orders of the same actions, in a world that records its calls."""

from __future__ import annotations

import numpy as np

from sensory_commutativity.scp.distances import mean_squared_error
from sensory_commutativity.scp.experiment import (
    REST_STEPS,
    commutation_experiment,
    compare_orders,
    distances_per_dof,
    endings_per_dof,
    iterate_order,
    orders_per_dof,
    play_order,
)
from sensory_commutativity.scp.sequences import compose, permute, sample_sequence
from sensory_commutativity.scp.world import Dof, play
from sensory_commutativity.worlds.corridor import Corridor
from tests.helpers import reset_world


class Recorder:
    """A world that observes all actions since the start."""

    dofs = (Dof("a", "1", 1.0), Dof("b", "1", 1.0))

    def __init__(self):
        self.actions: list[tuple[float, ...]] = []
        self.n_restores = 0

    def reset(self, rng):
        self.actions = []

    def snapshot(self):
        return tuple(self.actions)

    def restore(self, snapshot):
        self.n_restores += 1
        self.actions = list(snapshot)

    def step(self, action):
        self.actions.append(tuple(action))

    def observe(self):
        return np.array(self.actions)


class EventRecorder(Recorder):
    """A Recorder that also reports the number of its actions."""

    def happened(self):
        return len(self.actions)


SEQUENCE = np.arange(10.0).reshape(5, 2) / 10


def test_play_order_plays_the_sequence_and_rests():
    world = Recorder()
    for rest_steps in (0, 1, 7):
        world.step((7.0, 7.0))  # what happened before the start has no effect
        play_order(world, ((9.0, 9.0),), SEQUENCE, rest_steps)
        expected = compose(np.array([[9.0, 9.0]]), SEQUENCE, np.zeros((rest_steps, 2)))
        assert np.array_equal(world.observe(), expected)
    play_order(world, (), SEQUENCE)
    assert np.array_equal(world.observe(), compose(SEQUENCE, np.zeros((REST_STEPS, 2))))


def test_iterate_order_observes_the_start_and_every_step():
    world, start = Recorder(), ((9.0, 9.0),)
    play_order(world, start, SEQUENCE, 2)
    end = world.observe()
    observations = list(iterate_order(world, start, SEQUENCE, 2))
    assert [len(observation) for observation in observations] == list(range(1, 1 + 5 + 2 + 1))
    assert all(np.array_equal(o, end[: len(o)]) for o in observations)
    assert len(list(iterate_order(world, start, SEQUENCE))) == 1 + 5 + REST_STEPS


def test_iterate_order_plays_step_by_step():
    """The caller can look at the world in between; the rest is not played in advance."""
    world = reset_world(Corridor(wall=1))
    start, cells = world.snapshot(), []
    for observation in iterate_order(world, start, np.array([[1.0, 0.0]] * 2), 1):
        assert np.array_equal(observation, world.observe())
        cells.append(observation[0])
    assert cells == [0, 1, 1, 1]


def test_compare_orders_starts_both_from_the_snapshot():
    world = Recorder()
    world.step((7.0, 7.0))
    outcome = compare_orders(world, (), SEQUENCE, SEQUENCE[::-1], 0)
    assert world.n_restores == 2
    assert np.array_equal(outcome.first, SEQUENCE)
    assert np.array_equal(outcome.second, SEQUENCE[::-1])


def test_compare_orders_with_another_observation():
    """`observe` is called once, at the end of each order, instead of world.observe."""
    world, lengths = Recorder(), []

    def observe():
        lengths.append(len(world.actions))
        return {"last": world.actions[-1]}

    outcome = compare_orders(world, (), SEQUENCE, SEQUENCE[:2], 0, observe=observe)
    assert lengths == [5, 2]
    assert outcome == ({"last": tuple(SEQUENCE[-1])}, {"last": tuple(SEQUENCE[1])})


def test_outcomes_do_not_alias():
    world = reset_world(Corridor(wall=3))
    right, left = np.array([[1.0, 0.0]]), np.array([[-1.0, 0.0]])
    outcome = compare_orders(world, world.snapshot(), right, left)
    assert outcome.first.tolist() == [1, -1, 1]
    assert outcome.second.tolist() == [-1, -1, 1]


def test_commutation_experiment_plays_h_g_and_g_h():
    h, g, rest = SEQUENCE, -SEQUENCE[:2], np.zeros((1, 2))
    outcome = commutation_experiment(Recorder(), (), h, g, 1)
    assert np.array_equal(outcome.first, compose(h, g, rest))
    assert np.array_equal(outcome.second, compose(g, h, rest))


def test_play_prefers_the_world_s_own_method():
    world, calls = Recorder(), []
    play(world, SEQUENCE)
    assert np.array_equal(world.observe(), SEQUENCE)
    world.play = calls.append
    play(world, SEQUENCE)
    assert len(world.actions) == 5
    assert len(calls) == 1 and calls[0] is SEQUENCE


def test_orders_per_dof_permute_actions_of_one_dof():
    orders = list(orders_per_dof(Recorder(), 4, 20))
    assert [dof for dof, _, _ in orders] == ["a", "b"]
    for k, (_, sequence, permuted) in enumerate(orders):
        assert sequence.shape == permuted.shape == (20, 2)
        assert sequence[:, k].all() and not sequence[:, 1 - k].any()
        assert sorted(map(tuple, sequence)) == sorted(map(tuple, permuted))
        assert not np.array_equal(sequence, permuted)
    assert not np.array_equal(orders[0][1][:, 0], orders[1][1][:, 1])


def test_the_random_streams_of_a_dof_depend_on_its_name_only():
    class Reversed(Recorder):
        dofs = Recorder.dofs[::-1]

    original = {dof: sequence for dof, sequence, _ in orders_per_dof(Recorder(), 4, 20)}
    for dof, sequence, _ in orders_per_dof(Reversed(), 4, 20):
        assert np.array_equal(sequence[:, ::-1], original[dof])


def test_endings_per_dof_hold_observations_and_events():
    orders = {
        dof: (sequence, permuted) for dof, sequence, permuted in orders_per_dof(Recorder(), 4, 6)
    }
    for world, event in ((Recorder(), None), (EventRecorder(), 6 + 2)):
        endings = endings_per_dof(world, 4, 6, rest_steps=2)
        assert list(endings) == ["a", "b"]
        for dof, outcome in endings.items():
            for ending, sequence in zip(outcome, orders[dof], strict=True):
                assert np.array_equal(ending.observation, compose(sequence, np.zeros((2, 2))))
                assert ending.happened == event


def test_distances_per_dof_are_those_of_the_endings():
    for seed in range(10):
        distances = distances_per_dof(Corridor(wall=1), seed, 5)
        expected = {
            dof: mean_squared_error(outcome.first.observation, outcome.second.observation)
            for dof, outcome in endings_per_dof(Corridor(wall=1), seed, 5).items()
        }
        assert distances == expected
    assert distances_per_dof(Corridor(), 0, 5, lambda a, b: 7.0) == {"move": 7.0, "eyelid": 7.0}


def test_a_wall_breaks_commutation_as_often_as_expected():
    """In a corridor of one cell, steps to the right are lost; the probability is known.

    Of two steps the signs differ with probability 1/2, and the permutation swaps them with 1/2.
    """
    world = reset_world(Corridor(wall=0))
    start, n_unequal = world.snapshot(), 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        sequence = sample_sequence(rng, 2, 0, 2)
        n_unequal += not np.array_equal(
            *compare_orders(world, start, sequence, permute(rng, sequence))
        )
    assert abs(n_unequal - 50) < 4 * np.sqrt(200 * 0.25 * 0.75)
