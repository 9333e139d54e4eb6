"""The smallest world: an agent in a corridor, with a box and a wall.

It is a world with known answers, and a template for your own: it has all that the experiment needs.
The agent stands in an integer cell of a line. It senses three numbers: its cell, the cell of the
box, and how far its eyelid is open. It moves by whole cells and its eyelid by quarters: only the
sign of an action matters. A box in its way is pushed; nothing passes the wall. Sums of whole cells
and quarters are exact in floating point, and thus independent of their order.

>>> import numpy as np
>>> world = Corridor(wall=3, box=None)
>>> world.reset(np.random.default_rng(0))
>>> world.step(np.array([1.0, 0.0]))
>>> world.observe()
array([ 1., -1.,  1.])
"""

from __future__ import annotations

import numpy as np

from ..errors import ArgumentError
from ..scp.world import Dof

CorridorState = tuple[int, int, float]
"""Cell of the agent, cell of the box (-1 without one), and how far the eyelid is open."""


class Corridor:
    """A :class:`~sensory_commutativity.scp.world.World` with two degrees of freedom.

    They are ``move`` and ``eyelid``.

    Parameters
    ----------
    wall : int, optional
        The last cell that the agent or the box can reach. There is no wall by default.
    box : int, optional
        Cell of the box at the start. There is no box by default.
    """

    dofs: tuple[Dof, ...] = (
        Dof("move", "cells", 1.0),
        Dof("eyelid", "1", 0.25, displaces=False),
    )

    def __init__(self, wall: int | None = None, box: int | None = None):
        for name, cell in (("wall", wall), ("box", box)):
            if cell is not None and (isinstance(cell, bool) or not isinstance(cell, int)):
                raise ArgumentError(f"{name}: expected a whole number or None, got {cell!r}")
        self._last_cell = np.inf if wall is None else wall
        self._start: CorridorState = (0, -1 if box is None else box, 1.0)
        self._state = self._start

    def reset(self, rng: np.random.Generator) -> None:
        """Enter the start situation, which is always the same; `rng` is not used."""
        self._state = self._start

    def snapshot(self) -> CorridorState:
        return self._state

    def restore(self, snapshot: CorridorState) -> None:
        self._state = snapshot

    def step(self, action: np.ndarray) -> None:
        if np.shape(action) != (len(self.dofs),):
            raise ValueError(
                f"an action has {len(self.dofs)} elements, one per degree of freedom; "
                f"got an array of shape {np.shape(action)}"
            )
        agent, box, eyelid = self._state
        next_cell = agent + int(np.sign(action[0]))
        if next_cell == box != -1 and next_cell > agent:
            if box + 1 <= self._last_cell:  # otherwise the box stands against the wall
                agent, box = next_cell, box + 1
        elif next_cell <= self._last_cell:
            agent = next_cell
        eyelid += self.dofs[1].speed * float(np.sign(action[1]))
        self._state = (agent, box, eyelid)

    def observe(self) -> np.ndarray:
        """Cell of the agent, cell of the box, eyelid: float64 (3,)."""
        return np.array(self._state, np.float64)
