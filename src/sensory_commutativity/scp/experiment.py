"""The one idea: play the same actions in two orders from the same start; did the sensors end equal? (paper, definition 3)

Nothing here knows a world; a world is whatever has the five methods of :class:`~sensory_commutativity.worlds.base.World`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ..seeding import generator
from .distances import Distance, mean_squared_error
from .sequences import compose, no_op, permute, sample_sequence
from .world import Snapshot, World, play

REST_STEPS = 3
"""Steps without a command that end each order, so that what is compared is at rest; chosen: in Flatland's free space one is enough."""


class Ending(NamedTuple):
    """How one order ended: what is sensed at rest, and what the world tells of what happened (nothing, where it has no ``happened``)."""

    observation: np.ndarray
    happened: Any


class Outcome(NamedTuple):
    """The two final observations of an experiment."""

    first: np.ndarray
    second: np.ndarray


def ending(
    world: World, start: Snapshot, sequence: np.ndarray, rest_steps: int = REST_STEPS
) -> Ending:
    """Play `sequence`, float (steps, n_dofs), from `start` until the agent has come to rest."""
    world.restore(start)
    play(world, compose(sequence, no_op(rest_steps, sequence.shape[1])))
    happened = getattr(world, "happened", None)
    return Ending(world.observe(), happened() if happened else None)


def final_observation(
    world: World, start: Snapshot, sequence: np.ndarray, rest_steps: int = REST_STEPS
) -> np.ndarray:
    """What is sensed after `sequence`, float (steps, n_dofs), has been played from `start` and the agent has come to rest."""
    return ending(world, start, sequence, rest_steps).observation


def compare_orders(
    world: World,
    start: Snapshot,
    first: np.ndarray,
    second: np.ndarray,
    rest_steps: int = REST_STEPS,
) -> Outcome:
    """Play two sequences, each from `start`."""
    return Outcome(
        final_observation(world, start, first, rest_steps),
        final_observation(world, start, second, rest_steps),
    )


def sc_experiment(
    world: World,
    start: Snapshot,
    sequence: np.ndarray,
    rng: np.random.Generator,
    rest_steps: int = REST_STEPS,
) -> Outcome:
    """Sensory commutativity experiment: `sequence` against a random permutation of itself."""
    return compare_orders(world, start, sequence, permute(rng, sequence), rest_steps)


def commutation_experiment(
    world: World, start: Snapshot, h: np.ndarray, g: np.ndarray, rest_steps: int = REST_STEPS
) -> Outcome:
    """Do two sequences commute? First `h` then `g`, against first `g` then `h` (Philipona's conjecture, section II-C)."""
    return compare_orders(world, start, compose(h, g), compose(g, h), rest_steps)


def distances_per_dof(
    world: World,
    seed: int,
    length: int,
    distance: Distance = mean_squared_error,
    rest_steps: int = REST_STEPS,
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
    for dof, sequence, permuted in orders_per_dof(world, seed, length):
        found[dof] = distance(*compare_orders(world, start, sequence, permuted, rest_steps))
    return found


def endings_per_dof(
    world: World, seed: int, length: int, rest_steps: int = REST_STEPS
) -> dict[str, tuple[Ending, Ending]]:
    """As :func:`distances_per_dof`, but how both orders ended, for distances that are computed later and for what happened on the way."""
    world.reset(generator(seed, "situation"))
    start = world.snapshot()
    return {
        dof: (
            ending(world, start, sequence, rest_steps),
            ending(world, start, permuted, rest_steps),
        )
        for dof, sequence, permuted in orders_per_dof(world, seed, length)
    }


def orders_per_dof(
    world: World, seed: int, length: int
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Degree of freedom, a random sequence of it and a random permutation of that, for every degree of freedom, from streams of its own name."""
    for k, dof in enumerate(world.dofs):
        rng = generator(seed, "sequence", dof.name)
        sequence = sample_sequence(rng, length, k, len(world.dofs))
        yield dof.name, sequence, permute(rng, sequence)
