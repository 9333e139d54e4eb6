"""scp/equivalence.py: which observations are compared, and how.

Proposition 1 of the paper is tested in tests/properties/test_residues.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.scp.equivalence import (
    commutative_residue,
    commute,
    equivalent,
    is_commutative_residue,
)
from sensory_commutativity.scp.sequences import compose
from sensory_commutativity.worlds.corridor import Corridor
from tests.helpers import reset_world


def moves(*directions: float) -> np.ndarray:
    return np.array([(d, 0.0) for d in directions]).reshape(-1, 2)


@pytest.fixture
def start():
    """A corridor and its start, the first two arguments of all functions."""
    world = reset_world(Corridor(wall=1))
    return world, world.snapshot()


class RecordingDistance:
    """A constant distance that records the observations that it compares."""

    def __init__(self, value: float):
        self.value = value
        self.compared: list[tuple[list[float], list[float]]] = []

    def __call__(self, first, second):
        self.compared.append((first.tolist(), second.tolist()))
        return self.value


def test_equivalent_means_at_most_the_threshold(start):
    for value, threshold, expected in [
        (0.0, 0.0, True),
        (1e-300, 0.0, False),
        (2.0, 2.0, True),
        (2.1, 2.0, False),
    ]:
        distance = RecordingDistance(value)
        assert equivalent(*start, moves(1), moves(-1), distance, threshold) is expected
        assert distance.compared == [([1, -1, 1], [-1, -1, 1])]


def test_commute_compares_the_two_orders(start):
    distance = RecordingDistance(0.0)
    assert commute(*start, moves(1, 1), moves(-1), distance=distance)
    assert distance.compared == [([0, -1, 1], [1, -1, 1])]


def test_the_residue_follows_the_second_order(start):
    distance = RecordingDistance(0.0)
    residue, first, second = moves(-1, -1, -1), moves(1, 1), moves(-1)
    assert is_commutative_residue(*start, residue, first, second, distance=distance)
    assert distance.compared == [([0, -1, 1], [-2, -1, 1])]


def test_the_first_residue_among_the_candidates_is_returned(start):
    first, second = moves(1, 1), moves(-1)
    candidates = [moves(1), moves(-1), moves(-1, 0)]
    assert commutative_residue(*start, first, second, candidates) is candidates[1]
    assert commutative_residue(*start, first, second, [moves(1), moves(1, 1)]) is None
    assert commutative_residue(*start, first, second, []) is None


def test_rest_steps_are_played():
    class CountingCorridor(Corridor):
        n_steps = 0

        def step(self, action):
            self.n_steps += 1
            super().step(action)

    world = reset_world(CountingCorridor())
    assert equivalent(world, world.snapshot(), moves(1), compose(moves(1), moves()), rest_steps=4)
    assert world.n_steps == 2 * (1 + 4)
