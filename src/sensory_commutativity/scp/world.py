"""What the experiment asks of a world: five methods and a list of degrees of freedom.

A world is anything with a body that can be commanded and senses that can be read: the 2-D Flatland of this package, a robot in a physics
engine, or your own. The experiment (:mod:`sensory_commutativity.experiment`) knows worlds only through :class:`World`; nothing outside
:mod:`sensory_commutativity.worlds` imports a physics engine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

Snapshot = Any
"""An opaque value from which a world can be put back exactly; only the world that made it reads it."""


@dataclass(frozen=True)
class Dof:
    """A degree of freedom: one dimension of the action space (paper, section II-D).

    Attributes
    ----------
    name : str
        Lower-case, words joined by hyphens: ``left-elbow``.
    unit : str
        Unit of what an action moves: ``rad``, ``units`` (of length in Flatland), ``1`` (a pure number).
    speed : float
        What an action of 1 moves in all, in `unit`; a world may show the end of the motion a little later. An action of -1 moves it back.
    low, high : float
        Range of the moved quantity relative to its start, in `unit`; infinite where nothing stops it.
    displaces : bool
        Whether the motion displaces something in the world (Philipona's *displacement*): false for an eyelid or a turning eye.
    """

    name: str
    unit: str
    speed: float
    low: float = float("-inf")
    high: float = float("inf")
    displaces: bool = True


@runtime_checkable
class World(Protocol):
    """An embodied agent in its surroundings.

    Two promises make the SC-experiment meaningful, and every world of this package is tested for both: a replay from a restored snapshot is
    *bit-identical*, and in empty unbounded space every degree of freedom commutes.
    """

    dofs: tuple[Dof, ...]

    def reset(self, rng: np.random.Generator) -> None:
        """Draw a valid start situation, at rest."""

    def snapshot(self) -> Snapshot:
        """Return the present situation. The same steps from a restored snapshot and from here on end bit-identically."""

    def restore(self, snapshot: Snapshot) -> None:
        """Put the world back into the situation of `snapshot`."""

    def step(self, action: np.ndarray) -> None:
        """Play one action: float array of shape (len(dofs),), each element in [-1, 1]; beyond that it is clipped."""

    def observe(self) -> np.ndarray:
        """Return what the agent senses now; a new array, never a view of internal memory."""


def play(world: World, actions: np.ndarray) -> None:
    """Play `actions`, float array of shape (steps, len(dofs)), one after the other.

    A world that brings its own ``play(actions)`` (a compiled loop, say) is asked to do it; it must end exactly where single steps would.
    """
    own = getattr(world, "play", None)
    if own is not None:
        own(actions)
    else:
        for action in actions:
            world.step(action)
