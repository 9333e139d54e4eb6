"""SC-experiments with their controls: what else could be the reason that two orders end apart.

For worlds that tell what happened in an order (:class:`.Events`), such as Gymnasium environments.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from ..scp.distances import Distance
from ..scp.experiment import compare_orders, orders_per_dof, play_order
from ..scp.sequences import no_op, sample_sequence
from ..scp.world import Observation, Snapshot
from ..seeding import generator

COLUMNS = {
    "distance": "distance of the two final observations",
    "unrelated": "distance of the endings of two unrelated sequences",
    "noise": "distance of the endings of one order with two states of the generator",
    "touched": "1 if bodies touched in an order that do not touch without commands",
    "moved": "1 if a free object ended elsewhere in the other order",
    "amplitude": "largest action of the sequence, after scaling it to stay off the stops",
    "rest_steps": "steps of rest, mean of both orders",
    "not_still": "share of both orders that did not come to rest",
    "terminated": "1 if the episode terminated in one of the orders",
    "reaches_stop": "1 if an order of the sequence could reach a stop",
    "repeated": "1 if the first order, played again at the end of the start, ended equal",
}
"""What an experiment yields for every degree of freedom; NaN where it was not tried or is not
known."""
UNRELATED = 30
"""First experiments in which an unrelated sequence is played for comparison, too. Chosen."""
NOISE = 10
"""First experiments in which an order is repeated with another state of the generator. Chosen."""
MOVED = 1e-3
"""Metres by which the positions of an object differ if it ended elsewhere. Chosen."""


class ControlledWorld(Protocol):
    """What the controls ask of a world, beyond the protocol World."""

    dofs: tuple

    @property
    def knows_contacts(self) -> bool: ...

    def reset(self, rng: np.random.Generator) -> None: ...
    def snapshot(self) -> Snapshot: ...
    def restore(self, snapshot: Snapshot) -> None: ...
    def step(self, action: np.ndarray) -> None: ...
    def observe(self) -> Observation: ...
    def happened(self) -> Any: ...
    def limit(self, start: Snapshot, sequence: np.ndarray) -> np.ndarray: ...
    def reaches_stop(self, start: Snapshot, sequence: np.ndarray) -> bool: ...
    def reseed(self, seed: int) -> None: ...


def has_controls(world: Any) -> bool:
    """Whether a world tells enough for the controls."""
    return all(hasattr(world, name) for name in ("knows_contacts", "reaches_stop", "reseed"))


def play_with_controls(
    world: ControlledWorld, seed: int, length: int, distance: Distance, rest_steps: int, number: int
) -> np.ndarray:
    """One SC-experiment per degree of freedom, all from one start, with controls.

    Parameters
    ----------
    world : ControlledWorld
        Is reset.
    seed : int
        Of the experiment.
    length : int
    distance : callable
    rest_steps : int
        Most steps of rest.
    number : int
        Of the experiment: the first play more controls.

    Returns
    -------
    float64 (n_dofs, len(COLUMNS))
    """
    world.reset(generator(seed, "situation"))
    start = world.snapshot()

    def end() -> tuple[Observation, Any]:
        return world.observe(), world.happened()

    play_order(world, start, no_op(length, len(world.dofs)), rest_steps)
    idle = world.happened()
    rows, first_order = [], None
    for k, (name, sequence, permuted) in enumerate(orders_per_dof(world, seed, length, start)):
        first, second = compare_orders(world, start, sequence, permuted, rest_steps, end)
        if first_order is None:
            first_order = sequence, first[0]
        row = dict.fromkeys(COLUMNS, np.nan)
        row["distance"] = distance(first[0], second[0])
        if number < UNRELATED:
            other = sample_sequence(generator(seed, "unrelated", name), length, k, len(world.dofs))
            play_order(world, start, world.limit(start, other), rest_steps)
            row["unrelated"] = distance(first[0], world.observe())
        if number < NOISE:
            row["noise"] = distance(first[0], _with_other_noise(
                world, start, sequence, rest_steps, seed))  # fmt: skip
        events = first[1], second[1]
        if world.knows_contacts:
            row["touched"] = float(any(event.touched - idle.touched for event in events))
        if events[0].positions.size:
            shift = np.abs(events[0].positions - events[1].positions)
            row["moved"] = float(shift.max() > MOVED)
        row["amplitude"] = float(np.abs(sequence).max())
        row["rest_steps"] = float(np.mean([event.rest_steps for event in events]))
        row["not_still"] = float(np.mean([not event.still for event in events]))
        row["terminated"] = float(any(event.terminated for event in events))
        row["reaches_stop"] = float(world.reaches_stop(start, sequence))
        rows.append(row)
    assert first_order is not None
    play_order(world, start, first_order[0], rest_steps)
    repeated = float(np.array_equal(world.observe(), first_order[1]))
    for row in rows:
        row["repeated"] = repeated
    return np.array([[row[name] for name in COLUMNS] for row in rows], np.float64)


def _with_other_noise(
    world: ControlledWorld, start: Snapshot, sequence: np.ndarray, rest_steps: int, seed: int
) -> Observation:
    """The ending of an order after the environment's generator was reseeded."""
    play_order(world, start, sequence, rest_steps, lambda: world.reseed(seed % 2**31))
    return world.observe()
