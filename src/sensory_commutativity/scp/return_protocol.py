"""The SC-experiment without a restore: play, go back the way you came, play the other order.

A real robot cannot start twice from the same situation. Where the environment is reversible, the
opposite actions in reverse order lead back to the start; where something was shoved, the situation
has changed for good, and the other order ends elsewhere. Time passes meanwhile, so that things that
move by themselves, noise and drift make orders end apart as well. A control measures that: the
second order again, after another return.

One trial plays ``h``, its inverse, ``p`` (a permutation of ``h``), its inverse, ``p``, and its
inverse. It ends near where it began, and the next trial can go on from there.

>>> import numpy as np
>>> from sensory_commutativity import Corridor, inverse
>>> world = Corridor(wall=1)
>>> forth_and_back = np.array([[1, 0], [1, 0], [-1, 0.0]])  # blocked: the way back ends elsewhere
>>> legs = play_trial(world, forth_and_back, inverse(-forth_and_back))
>>> compare_legs(legs, lambda a, b: float(abs(a - b).sum())).returned
1.0
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import Any, NamedTuple

import numpy as np

from ..seeding import generator
from .distances import Distance
from .experiment import REST_STEPS, orders_of_dof, play_and_rest
from .sequences import check_sequence, inverse
from .world import InverseReporter, SequenceLimiter, SteppableWorld, TrialListener, World

HOLD = 10
"""Steps for which an action is held on the way to the next trial. Chosen: as in starts of Gymnasium
environments."""
SETTLE = 100
"""Steps without a command after them; at most so many in a world that tells when it is still.
Chosen: a pushed object in Flatland loses a tenth of its speed in a step."""


class Legs(NamedTuple):
    """What was observed in a trial of the return protocol, in the order of time.

    Attributes
    ----------
    start : array
        Before the trial.
    first : array
        At the end of ``h``.
    returned : array
        After the inverse of ``h``.
    second : array
        At the end of ``p``, the same actions in another order.
    returned_again : array
        After the inverse of ``p``.
    repeated : array
        At the end of ``p``, played a second time.
    """

    start: Any
    first: Any
    returned: Any
    second: Any
    returned_again: Any
    repeated: Any


class ReturnDistances(NamedTuple):
    """Distances of a trial of the return protocol.

    Attributes
    ----------
    distance : float
        Of the ends of the two orders.
    control : float
        Of the ends of the same order played twice. As much time passes between them as between
        the two orders.
    returned : float
        Of the view of the start before and after the first return.
    waited : float
        Of the views at the start and after the second return: `returned`, a little later.
    """

    distance: float
    control: float
    returned: float
    waited: float


def play_trial(
    world: SteppableWorld,
    sequence: np.ndarray,
    permuted: np.ndarray,
    rest_steps: int = REST_STEPS,
    observe: Callable[[], Any] | None = None,
    after_return: Callable[[], None] | None = None,
    come_back: bool = True,
) -> Legs:
    """Play one trial of the return protocol from where the world is.

    Parameters
    ----------
    world : SteppableWorld
        Is left where the last return leads.
    sequence, permuted : float (steps, n_dofs), in [-1, 1]
        The same actions in two orders.
    rest_steps : int
        Steps without a command after each of the six legs; at most so many in a world that tells
        when it is still.
    observe : callable, optional
        What to record; by default ``world.observe``.
    after_return : callable, optional
        Is called after the first and the second return, before the view is recorded; may bring the
        robot nearer to where it started.
    come_back : bool
        Whether to return at the end of the trial, too.

    Raises
    ------
    ArgumentError
        If a sequence has another shape or holds values outside [-1, 1].
    """
    for actions in (sequence, permuted):
        check_sequence(actions, len(world.dofs))
    observe = observe or world.observe
    views = [observe()]
    for actions in (sequence, permuted):
        play_and_rest(world, actions, rest_steps)
        views.append(observe())
        play_and_rest(world, inverse(actions), rest_steps)
        if after_return is not None:
            after_return()
        views.append(observe())
    play_and_rest(world, permuted, rest_steps)
    views.append(observe())
    if come_back:
        play_and_rest(world, inverse(permuted), rest_steps)
    return Legs(*views)


def compare_legs(legs: Legs, distance: Distance) -> ReturnDistances:
    """The distances of a trial."""
    return ReturnDistances(
        distance(legs.first, legs.second),
        distance(legs.second, legs.repeated),
        distance(legs.start, legs.returned),
        distance(legs.start, legs.returned_again),
    )


def known_inverses(world: SteppableWorld) -> np.ndarray:
    """For which degrees of freedom an action of -a undoes an action of a: bool (n_dofs,).

    All of a world of this package. Others say so (:class:`.InverseReporter`).
    """
    if isinstance(world, InverseReporter):
        return np.asarray(world.has_inverse(), bool)
    return np.ones(len(world.dofs), bool)


def wander(world: SteppableWorld, seed: int, steps: int, settle: int = SETTLE) -> None:
    """Play random actions, so that the next trial starts elsewhere, and wait until nothing moves.

    Degrees of freedom that displace nothing stay where they are, away from their stops. Each action
    is uniform in [-1, 1] and held for HOLD steps, otherwise the agent hardly leaves its place.
    """
    rng = generator(seed, "wander")
    actions = rng.uniform(-1.0, 1.0, (-(-steps // HOLD), len(world.dofs)))
    if any(dof.displaces for dof in world.dofs):
        actions *= [dof.displaces for dof in world.dofs]
    play_and_rest(world, np.repeat(actions, HOLD, axis=0)[:steps], settle)


def trials_per_dof(
    world: SteppableWorld,
    seed: int,
    length: int,
    distance: Distance,
    rest_steps: int = REST_STEPS,
    dofs: Collection[str] | None = None,
) -> Iterator[tuple[str, ReturnDistances]]:
    """One trial of each degree of freedom, one after the other, from where the world is.

    The sequences are those that :func:`.orders_per_dof` yields.

    Parameters
    ----------
    world : SteppableWorld
    seed : int
        Determines a sequence and a permutation for each degree of freedom.
    length : int
        Actions in a sequence.
    distance : callable
    rest_steps : int
    dofs : collection of str, optional
        Those to try; by default all.
    """
    for k, dof in enumerate(world.dofs):
        if dofs is None or dof.name in dofs:
            # What is left to the stops depends on where the last trial ended.
            start = None
            if isinstance(world, SequenceLimiter) and isinstance(world, World):
                start = world.snapshot()
            sequence, permuted = orders_of_dof(world, seed, length, k, start)
            if isinstance(world, TrialListener):
                world.begin_trial(k)
            legs = play_trial(world, sequence, permuted, rest_steps)
            if isinstance(world, TrialListener):
                world.end_trial()
            yield dof.name, compare_legs(legs, distance)
