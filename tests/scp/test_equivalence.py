"""residues.py: how sequences are compared, with a distance and a world that can be read off; proposition 1 is in tests/properties."""

from __future__ import annotations

import numpy as np
import pytest
from tests.helpers import reset_world

from sensory_commutativity.scp.equivalence import (
    commutative_residue,
    commute,
    equivalent,
    is_commutative_residue,
)
from sensory_commutativity.scp.sequences import compose
from sensory_commutativity.worlds.corridor import Corridor


def moves(*directions: float) -> np.ndarray:
    return np.array([(d, 0.0) for d in directions]).reshape(-1, 2)


@pytest.fixture
def where():
    world = reset_world(Corridor(wall=1))
    return world, world.snapshot()


class Recorder:
    """A distance that always says the same, and remembers what it was given."""

    def __init__(self, says: float):
        self.says, self.given = says, []

    def __call__(self, first, second):
        self.given.append((first.tolist(), second.tolist()))
        return self.says


@pytest.mark.parametrize(
    ("says", "threshold", "expected"),
    [(0.0, 0.0, True), (1e-300, 0.0, False), (2.0, 2.0, True), (2.1, 2.0, False)],
)
def test_equivalent_means_at_most_the_threshold(where, says, threshold, expected):
    distance = Recorder(says)
    assert equivalent(*where, moves(1), moves(-1), distance, threshold) is expected
    assert distance.given == [([1, -1, 1], [-1, -1, 1])]


def test_commute_compares_the_two_orders(where):
    distance = Recorder(0.0)
    assert commute(*where, moves(1, 1), moves(-1), distance=distance)
    assert distance.given == [([0, -1, 1], [1, -1, 1])]


def test_the_residue_follows_the_second_order(where):
    distance = Recorder(0.0)
    assert is_commutative_residue(
        *where, moves(-1, -1, -1), moves(1, 1), moves(-1), distance=distance
    )
    assert distance.given == [([0, -1, 1], [-2, -1, 1])]


def test_no_residue_among_the_candidates(where):
    assert commutative_residue(*where, moves(1, 1), moves(-1), [moves(1), moves(1, 1)]) is None
    assert commutative_residue(*where, moves(1, 1), moves(-1), []) is None


def test_the_first_residue_is_returned_itself(where):
    candidates = [moves(1), moves(-1), moves(-1, 0)]
    assert commutative_residue(*where, moves(1, 1), moves(-1), candidates) is candidates[1]


def test_rest_steps_are_played(where):
    class Fidget(Corridor):
        steps = 0

        def step(self, action):
            self.steps += 1
            super().step(action)

    world = reset_world(Fidget())
    start = world.snapshot()
    assert equivalent(world, start, moves(1), compose(moves(1), moves()), rest_steps=4)
    assert world.steps == 2 * (1 + 4)
