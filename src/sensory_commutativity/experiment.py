"""The one idea: play the same actions in two orders from the same start; did the sensors end equal? (paper, definition 3)

Nothing here knows a world; a world is whatever has the five methods of :class:`~sensory_commutativity.worlds.base.World`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .distances import Distance, mean_squared_error
from .seeding import generator
from .sequences import compose, no_op, permute, sample_sequence
from .worlds.base import Snapshot, World, play

REST_STEPS = 3
"""Steps without a command that end each order, so that what is compared is at rest; chosen: in Flatland's free space one is enough."""


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


def distances_per_dof(
    world: World, seed: int, length: int, distance: Distance = mean_squared_error, rest_steps: int = REST_STEPS
) -> dict[str, float]:
    """One SC-experiment of every degree of freedom, all from the same random start situation.

    Parameters
    ----------
    world : World
        Is reset.
    seed : int
        Everything random follows from it: the situation, and a sequence and a permutation for each degree of freedom by its name.
    length : int
        Actions in a sequence.

    Returns
    -------
    dict
        Name of the degree of freedom -> distance of the two final observations.
    """
    world.reset(generator(seed, "situation"))
    start = world.snapshot()
    found = {}
    for k, dof in enumerate(world.dofs):
        rng = generator(seed, "sequence", dof.name)
        sequence = sample_sequence(rng, length, k, len(world.dofs))
        found[dof.name] = distance(*sc_experiment(world, start, sequence, rng, rest_steps))
    return found
