"""The one idea: play the same actions in two orders from the same start; did the sensors end equal? (paper, definition 3)

Nothing here knows a world; a world is whatever has the five methods of :class:`~sensory_commutativity.worlds.base.World`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .sequences import compose, no_op, permute
from .worlds.base import Snapshot, World, play

REST_STEPS = 3
"""Steps without a command that end each order, so that what is compared is at rest; chosen, two are enough in Flatland."""


class Outcome(NamedTuple):
    """The two final observations of an experiment."""

    first: np.ndarray
    second: np.ndarray


def final_observation(world: World, start: Snapshot, sequence: np.ndarray, rest_steps: int = REST_STEPS) -> np.ndarray:
    """What is sensed after `sequence`, float (steps, n_dofs), has been played from `start` and the agent has come to rest."""
    world.restore(start)
    play(world, compose(sequence, no_op(rest_steps, sequence.shape[1])))
    return world.observe()


def compare_orders(world: World, start: Snapshot, first: np.ndarray, second: np.ndarray, rest_steps: int = REST_STEPS) -> Outcome:
    """Play two sequences, each from `start`."""
    return Outcome(final_observation(world, start, first, rest_steps), final_observation(world, start, second, rest_steps))


def sc_experiment(world: World, start: Snapshot, sequence: np.ndarray, rng: np.random.Generator, rest_steps: int = REST_STEPS) -> Outcome:
    """Sensory commutativity experiment: `sequence` against a random permutation of itself."""
    return compare_orders(world, start, sequence, permute(rng, sequence), rest_steps)


def commutation_experiment(world: World, start: Snapshot, h: np.ndarray, g: np.ndarray, rest_steps: int = REST_STEPS) -> Outcome:
    """Do two sequences commute? First `h` then `g`, against first `g` then `h` (Philipona's conjecture, section II-C)."""
    return compare_orders(world, start, compose(h, g), compose(g, h), rest_steps)
