"""The SC-experiment: the same actions in two orders from the same start (paper, definition 3).

This module and :mod:`.return_protocol`, which does without a restore, are the only ones that play
orders. They know worlds only through the protocols of :mod:`sensory_commutativity.scp.world`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import Any, NamedTuple

import numpy as np

from ..seeding import generator
from .distances import Distance, mean_squared_error
from .sequences import check_sequence, compose, no_op, permute, sample_sequence
from .world import (
    EventReporter,
    Observation,
    Resting,
    SequenceLimiter,
    Snapshot,
    SteppableWorld,
    World,
    play,
)

REST_STEPS = 3
"""Steps without a command that end each order, so that the agent is at rest when its sensors are
compared. Chosen: in Flatland's free space one is enough."""


class Ending(NamedTuple):
    """How one order ended.

    Attributes
    ----------
    observation : array
        What the agent senses at rest.
    happened : object
        What the world reports about the order; None if it is no
        :class:`~sensory_commutativity.scp.world.EventReporter`.
    """

    observation: Observation
    happened: Any


class Outcome(NamedTuple):
    """What was observed at the end of each of the two orders of an experiment."""

    first: Any
    second: Any


def play_order(
    world: World,
    start: Snapshot,
    sequence: np.ndarray,
    rest_steps: int = REST_STEPS,
    prepare: Callable[[], None] | None = None,
) -> None:
    """Play `sequence` from `start`, then rest; the world is left at the end of the order.

    Parameters
    ----------
    world : World
    start : Snapshot
        Of `world`.
    sequence : float (steps, n_dofs), in [-1, 1]
    rest_steps : int
        Steps without a command at the end; at most so many in a world that tells when it is still
        (:class:`~sensory_commutativity.scp.world.Resting`).
    prepare : callable, optional
        Is called between the restore and the first action.

    Raises
    ------
    ArgumentError
        If `sequence` has another shape or holds values outside [-1, 1].
    """
    check_sequence(sequence, len(world.dofs))
    world.restore(start)
    if prepare is not None:
        prepare()
    play_and_rest(world, sequence, rest_steps)


def play_and_rest(world: SteppableWorld, sequence: np.ndarray, rest_steps: int) -> None:
    """Play `sequence` from where the world is, then rest; arguments as for :func:`play_order`."""
    if isinstance(world, Resting):
        play(world, sequence)
        world.rest(rest_steps)
    else:
        play(world, compose(sequence, no_op(rest_steps, sequence.shape[1])))


def iterate_order(
    world: World, start: Snapshot, sequence: np.ndarray, rest_steps: int = REST_STEPS
) -> Iterator[Observation]:
    """As :func:`play_order`, step by step: observations at the start and after every step.

    It always takes `rest_steps` steps of rest, also in a world that tells when it is still.
    """
    check_sequence(sequence, len(world.dofs))
    world.restore(start)
    yield world.observe()
    for action in compose(sequence, no_op(rest_steps, sequence.shape[1])):
        world.step(action)
        yield world.observe()


def compare_orders(
    world: World,
    start: Snapshot,
    first: np.ndarray,
    second: np.ndarray,
    rest_steps: int = REST_STEPS,
    observe: Callable[[], Any] | None = None,
) -> Outcome:
    """Play two sequences, each from `start`, and observe the end of each.

    Parameters
    ----------
    world, start, rest_steps
        As for :func:`play_order`.
    first, second : float (steps, n_dofs), in [-1, 1]
    observe : callable, optional
        What to record at the end of an order; by default ``world.observe``.
    """
    observe = observe or world.observe
    observed = []
    for sequence in (first, second):
        play_order(world, start, sequence, rest_steps)
        observed.append(observe())
    return Outcome(*observed)


def commutation_experiment(
    world: World, start: Snapshot, h: np.ndarray, g: np.ndarray, rest_steps: int = REST_STEPS
) -> Outcome:
    """First `h` then `g`, against first `g` then `h` (Philipona's conjecture, section II-C)."""
    return compare_orders(world, start, compose(h, g), compose(g, h), rest_steps)


def orders_per_dof(
    world: World, seed: int, length: int, start: Snapshot = None
) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield a random sequence and a random permutation of it for every degree of freedom.

    Each degree of freedom has a random stream of its own, keyed by its name. A world that can keep
    sequences from reaching a stop (:class:`~sensory_commutativity.scp.world.SequenceLimiter`) does
    so, if `start` is given.

    Yields
    ------
    dof : str
    sequence, permuted : float (length, n_dofs), in [-1, 1]
    """
    for k, dof in enumerate(world.dofs):
        yield dof.name, *orders_of_dof(world, seed, length, k, start)


def orders_of_dof(
    world: SteppableWorld, seed: int, length: int, k: int, start: Snapshot = None
) -> tuple[np.ndarray, np.ndarray]:
    """As :func:`orders_per_dof`, for the degree of freedom number `k` alone."""
    rng = generator(seed, "sequence", world.dofs[k].name)
    sequence = sample_sequence(rng, length, k, len(world.dofs))
    if start is not None and isinstance(world, SequenceLimiter):
        sequence = world.limit(start, sequence)
    return sequence, permute(rng, sequence)


def endings_per_dof(
    world: World, seed: int, length: int, rest_steps: int = REST_STEPS
) -> dict[str, Outcome]:
    """One SC-experiment per degree of freedom, all from one random start: how both orders ended.

    Parameters
    ----------
    world : World
        Is reset.
    seed : int
        Determines everything random: the start, and a sequence and a permutation for each degree
        of freedom.
    length : int
        Actions in a sequence.
    rest_steps : int

    Returns
    -------
    dict
        Name of the degree of freedom -> an Outcome that holds the Ending of each order.
    """
    world.reset(generator(seed, "situation"))
    start = world.snapshot()

    def observe() -> Ending:
        observation = world.observe()
        return Ending(observation, world.happened() if isinstance(world, EventReporter) else None)

    return {
        dof: compare_orders(world, start, sequence, permuted, rest_steps, observe)
        for dof, sequence, permuted in orders_per_dof(world, seed, length, start)
    }


def distances_per_dof(
    world: World,
    seed: int,
    length: int,
    distance: Distance = mean_squared_error,
    rest_steps: int = REST_STEPS,
    dofs: Collection[str] | None = None,
) -> dict[str, float]:
    """As :func:`endings_per_dof`, but the distance of the two final observations.

    With `dofs`, only these degrees of freedom are tried; what is random in them stays the same.
    """
    world.reset(generator(seed, "situation"))
    start = world.snapshot()
    return {
        dof: distance(*compare_orders(world, start, sequence, permuted, rest_steps))
        for dof, sequence, permuted in orders_per_dof(world, seed, length, start)
        if dofs is None or dof in dofs
    }
