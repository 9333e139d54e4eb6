"""The contract between the experiment and a world: five methods and a tuple of degrees of freedom.

A world is anything with a body that can be commanded and sensors that can be read: the 2-D
Flatland of this package, a robot in a physics engine, or your own. The experiment
(:mod:`sensory_commutativity.scp.experiment`) knows worlds only through the protocols below.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

Snapshot = Any
"""An opaque value from which a world can be restored exactly; only its own world reads it."""

Observation = np.ndarray
"""What the agent senses at one moment, of any shape and number type that stays the same."""


@dataclass(frozen=True)
class Dof:
    """A degree of freedom: one dimension of the action space (paper, section II-D).

    Attributes
    ----------
    name : str
        Lower case, words joined by hyphens: ``left-elbow``.
    unit : str
        Unit of the moved quantity: ``rad``, ``units`` (of length in Flatland), ``1`` (a pure
        number).
    speed : float
        How far one action of 1 moves in total, in `unit`; the motion may end a little later than
        the step. An action of -1 moves back by as much.
    low, high : float
        Range of the moved quantity relative to its start, in `unit`; infinite without stops.
    displaces : bool
        Whether the motion displaces matter (Philipona's *displacement*): false for an eyelid or
        an eye that turns.
    """

    name: str
    unit: str
    speed: float
    low: float = float("-inf")
    high: float = float("inf")
    displaces: bool = True


@runtime_checkable
class SteppableWorld(Protocol):
    """What can be commanded and observed but not put back: a real robot, or any environment.

    The return protocol (:mod:`sensory_commutativity.scp.return_protocol`) asks for no more.
    """

    dofs: tuple[Dof, ...]

    def step(self, action: np.ndarray) -> None:
        """Play one action: float array of shape (len(dofs),), clipped to [-1, 1]."""

    def observe(self) -> Observation:
        """Return what the agent senses now: a new array, never a view of internal memory."""


@runtime_checkable
class World(Protocol):
    """An embodied agent and its environment.

    The SC-experiment rests on two promises, and every world of this package is tested for both: a
    replay from a restored snapshot is *bit-identical*, and in empty unbounded space every degree
    of freedom commutes. :func:`~sensory_commutativity.scp.check.check_world` tests the first.

    An attribute ``name``, if there is one, is used in tables and titles.
    """

    dofs: tuple[Dof, ...]

    def reset(self, rng: np.random.Generator) -> None:
        """Draw a valid start situation, at rest."""

    def snapshot(self) -> Snapshot:
        """Return the present situation.

        The same steps from here, and from the restored snapshot, end bit-identically.
        """

    def restore(self, snapshot: Snapshot) -> None:
        """Return to the situation of `snapshot`."""

    def step(self, action: np.ndarray) -> None:
        """Play one action: float array of shape (len(dofs),), clipped to [-1, 1]."""

    def observe(self) -> Observation:
        """Return what the agent senses now: a new array, never a view of internal memory."""


@runtime_checkable
class SequencePlayer(Protocol):
    """A world that plays a whole sequence faster than step by step, with the same result."""

    def play(self, actions: np.ndarray) -> None:
        """Play `actions`, float array of shape (steps, len(dofs)); ends where single steps end."""


@runtime_checkable
class EventReporter(Protocol):
    """A world that knows more about the last sequence than the agent senses, such as contacts."""

    def happened(self) -> Any:
        """Return what happened since the last :meth:`World.restore` or :meth:`World.reset`."""


@runtime_checkable
class Resting(Protocol):
    """A world that can tell when it has come to rest."""

    def rest(self, most: int) -> None:
        """Command nothing until nothing moves, for at most `most` steps."""


@runtime_checkable
class SequenceLimiter(Protocol):
    """A world that can keep sequences from reaching a stop of its degrees of freedom."""

    def limit(self, start: Snapshot, sequence: np.ndarray) -> np.ndarray:
        """Return `sequence`, scaled so that no order of it reaches a stop from `start`."""


@runtime_checkable
class InverseReporter(Protocol):
    """A world that knows for which degrees of freedom an action of -a undoes an action of a."""

    def has_inverse(self) -> np.ndarray:
        """Return bool (len(dofs),): true for commands of velocity or of a change of position.

        The inverse of a force or of a position to go to is not known.
        """


@runtime_checkable
class TrialListener(Protocol):
    """A world that is told when a trial of the return protocol begins and ends, to record it."""

    def begin_trial(self, dof: int) -> None:
        """From now on, actions and observations belong to the next trial, of this one."""

    def end_trial(self) -> None:
        """The trial is over."""


def play(world: SteppableWorld, actions: np.ndarray) -> None:
    """Play `actions`, float array of shape (steps, len(dofs)), one after the other."""
    if isinstance(world, SequencePlayer):
        world.play(actions)
    else:
        for action in actions:
            world.step(action)
