"""What the robot touches: in how many control steps, and what."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

from ..bullet import pybullet
from ..scenes.scenery import Scenery


class ContactCounts(NamedTuple):
    """In how many control steps the robot touched what, even if only in one substep.

    Attributes
    ----------
    steps : int
        Control steps since counting started.
    fixed : int
        Touched a fixture, or the floor with a link other than the base.
    movable : int
        Touched a movable object.
    itself : int
        Touched itself.
    at_limit : int
        A joint was commanded beyond its limit.
    """

    steps: int
    fixed: int
    movable: int
    itself: int
    at_limit: int


class ContactCounter:
    """Counts the control steps in which the robot touches something.

    Parameters
    ----------
    client : int
        PyBullet's number of the world.
    robot : int
        PyBullet's number of the robot.
    scenery : Scenery
    """

    def __init__(self, client: int, robot: int, scenery: Scenery):
        self._client, self._robot = client, robot
        self._event_of_body = {
            robot: "itself",
            **dict.fromkeys(scenery.fixtures, "fixed"),
            **dict.fromkeys(scenery.movables, "movable"),
        }
        if scenery.floor is not None:
            self._event_of_body[scenery.floor] = "fixed"
        self._counts: Counter[str] = Counter()
        self._events: set[str] = set()  # of the current control step

    def reset(self) -> None:
        """Set all counts to zero."""
        self._counts.clear()

    def record_substep(self, at_limit: bool) -> None:
        """Record the contacts after a physics step, and whether a limit stopped a joint."""
        if at_limit:
            self._events.add("at_limit")
        for point in pybullet.getContactPoints(self._robot, physicsClientId=self._client):
            body_a, body_b, normal_force = point[1], point[2], point[9]
            if normal_force > 0:  # else the bodies are only near each other
                touched = body_b if body_a == self._robot else body_a
                self._events.add(self._event_of_body[touched])

    def end_step(self) -> None:
        """Count the events of a control step and start the next one."""
        self._counts.update(["steps", *self._events])
        self._events.clear()

    def counts(self) -> ContactCounts:
        """Return the counts since the last reset."""
        return ContactCounts(*(self._counts[field] for field in ContactCounts._fields))
