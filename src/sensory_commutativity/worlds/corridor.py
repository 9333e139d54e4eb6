"""The smallest world: an agent in a corridor with a box and a wall. A template for your own, and a world with known answers.

The agent stands at an integer place on a line and senses three numbers: where it is, where the box is, and how far its eyelid is open. It moves by
whole places and the eyelid by quarters (the sign of the action); a box in its way is pushed, and nothing passes the wall. Whole places and quarters
are exact in floating point, so that sums do not depend on their order: 0.1 + 0.2 + 0.3 does. Every hook that the experiment needs is here.

>>> import numpy as np
>>> world = Corridor(wall=3, box=None)
>>> world.reset(np.random.default_rng(0))
>>> world.step(np.array([1.0, 0.0]))
>>> world.observe()
array([ 1., -1.,  1.])
"""

from __future__ import annotations

import numpy as np

from ..scp.world import Dof

Place = tuple[int, int, float]
"""Where the agent is, where the box is (-1: there is none), how far the eyelid is open."""


class Corridor:
    """A :class:`~sensory_commutativity.worlds.base.World` with two degrees of freedom: ``move`` and ``eyelid``.

    Parameters
    ----------
    wall : int or None
        The last place that the agent or the box can reach; None for no wall.
    box : int or None
        Where the box stands at the start; None for no box.
    """

    dofs = (Dof("move", "places", 1.0), Dof("eyelid", "1", 0.25, displaces=False))

    def __init__(self, wall: int | None = None, box: int | None = None):
        self._wall = np.inf if wall is None else wall
        self._box_start = -1 if box is None else box
        self._place: Place = (0, self._box_start, 1.0)

    def reset(self, rng: np.random.Generator) -> None:
        """The start situation is always the same; `rng` is not used."""
        self._place = (0, self._box_start, 1.0)

    def snapshot(self) -> Place:
        return self._place

    def restore(self, snapshot: Place) -> None:
        self._place = snapshot

    def step(self, action: np.ndarray) -> None:
        if np.shape(action) != (len(self.dofs),):
            raise ValueError(
                f"an action has {len(self.dofs)} elements, one per degree of freedom; got an array of shape {np.shape(action)}"
            )
        agent, box, eyelid = self._place
        to = agent + int(np.sign(action[0]))
        if (
            to == box != -1 and to > agent
        ):  # a box in front is pushed ahead, unless it stands against the wall
            if box + 1 <= self._wall:
                agent, box = to, box + 1
        elif to <= self._wall:
            agent = to
        self._place = (agent, box, eyelid + self.dofs[1].speed * float(np.sign(action[1])))

    def observe(self) -> np.ndarray:
        """Place of the agent, place of the box, eyelid: float64 (3,)."""
        return np.array(self._place, np.float64)
