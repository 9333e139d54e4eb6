"""experiment.py: the two orders of one sequence, in a world that notes down what is asked of it."""

from __future__ import annotations

import numpy as np
import pytest
from tests.helpers import reset_world

from sensory_commutativity.scp.experiment import (
    REST_STEPS,
    commutation_experiment,
    compare_orders,
    final_observation,
    sc_experiment,
)
from sensory_commutativity.scp.sequences import compose, sample_sequence
from sensory_commutativity.scp.world import Dof, play
from sensory_commutativity.worlds.corridor import Corridor


class Diary:
    """A world that sees all that it has done since it was restored."""

    dofs = (Dof("a", "1", 1.0), Dof("b", "1", 1.0))

    def __init__(self):
        self.done: list = []
        self.restored = 0

    def reset(self, rng):
        self.done = []

    def snapshot(self):
        return tuple(self.done)

    def restore(self, snapshot):
        self.restored += 1
        self.done = list(snapshot)

    def step(self, action):
        self.done.append(tuple(action))

    def observe(self):
        return np.array(self.done)


SEQUENCE = np.arange(10.0).reshape(5, 2)


@pytest.mark.parametrize("rest_steps", [0, 1, 7])
def test_a_sequence_is_played_and_then_the_agent_rests(rest_steps):
    seen = final_observation(Diary(), ((9.0, 9.0),), SEQUENCE, rest_steps)
    assert np.array_equal(
        seen, compose(np.array([[9.0, 9.0]]), SEQUENCE, np.zeros((rest_steps, 2)))
    )


def test_the_agent_rests_three_steps_unless_told():
    assert REST_STEPS == 3
    assert len(final_observation(Diary(), (), SEQUENCE)) == 5 + 3


def test_both_orders_begin_at_the_start():
    world = Diary()
    world.step((7.0, 7.0))  # what happened before does not matter
    outcome = compare_orders(world, (), SEQUENCE, SEQUENCE[::-1], 0)
    assert world.restored == 2
    assert np.array_equal(outcome.first, SEQUENCE)
    assert np.array_equal(outcome.second, SEQUENCE[::-1])


def test_an_sc_experiment_permutes_the_same_actions():
    world, rng = Diary(), np.random.default_rng(4)
    outcome = sc_experiment(world, (), SEQUENCE, rng, 2)
    assert np.array_equal(outcome.first[:5], SEQUENCE)
    assert not np.array_equal(outcome.second[:5], SEQUENCE)
    assert sorted(map(tuple, outcome.second[:5])) == sorted(map(tuple, SEQUENCE))
    assert not outcome.first[5:].any() and not outcome.second[5:].any()
    assert np.array_equal(
        outcome.second, sc_experiment(world, (), SEQUENCE, np.random.default_rng(4), 2).second
    )


def test_a_commutation_experiment_plays_h_g_and_g_h():
    h, g = SEQUENCE, -SEQUENCE[:2]
    outcome = commutation_experiment(Diary(), (), h, g, 1)
    rest = np.zeros((1, 2))
    assert np.array_equal(outcome.first, compose(h, g, rest))
    assert np.array_equal(outcome.second, compose(g, h, rest))


def test_the_outcomes_of_a_real_world_do_not_alias():
    world = reset_world(Corridor(wall=3))
    outcome = compare_orders(
        world, world.snapshot(), np.array([[1.0, 0.0]]), np.array([[-1.0, 0.0]])
    )
    assert outcome.first.tolist() == [1, -1, 1]
    assert outcome.second.tolist() == [-1, -1, 1]


def test_a_world_without_its_own_play_is_stepped_and_one_with_it_is_asked():
    world, asked = Diary(), []
    play(world, SEQUENCE)
    assert np.array_equal(world.observe(), SEQUENCE)
    world.play = asked.append
    play(world, SEQUENCE)
    assert len(world.done) == 5
    assert len(asked) == 1 and asked[0] is SEQUENCE


def test_a_wall_makes_an_experiment_fail_to_commute():
    """Steps to the right that the wall swallows depend on the order; how often is known by heart in a short corridor."""
    world = reset_world(Corridor(wall=0))  # every step to the right from place 0 is lost
    start, unequal = world.snapshot(), 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        outcome = sc_experiment(world, start, sample_sequence(rng, 2, 0, 2), rng)
        unequal += not np.array_equal(*outcome)
    # of two steps the signs differ with probability 1/2, and the permutation swaps them with 1/2
    assert abs(unequal - 50) < 4 * np.sqrt(200 * 0.25 * 0.75)
