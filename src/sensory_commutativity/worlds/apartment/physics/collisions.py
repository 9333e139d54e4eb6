"""Geometric queries: distances, penetration, and what is below a point."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from ..bullet import pybullet
from ..scenes.scenery import Scenery
from .simulated_robot import SimulatedRobot

_RAY_END = -0.5
"""Metres: rays downwards end below the floor."""
_MIN_UPWARD = 0.99
"""Of a surface normal's z component; chosen: surfaces inclined by less than 8 degrees carry."""


class CollisionQueries:
    """Answers geometric questions about the current poses.

    Parameters
    ----------
    client : int
        PyBullet's number of the world.
    robot : SimulatedRobot
    scenery : Scenery
    """

    def __init__(self, client: int, robot: SimulatedRobot, scenery: Scenery):
        self._client, self._robot, self._scenery = client, robot, scenery

    def robot_penetrates(self, depth: float = 0.0) -> bool:
        """Return whether the robot is more than `depth` metres inside something or itself."""
        return self._penetrates(self._robot.id, depth)

    def object_penetrates(self, i: int, depth: float = 0.003) -> bool:
        """Return whether the i-th movable object is more than `depth` metres inside something.

        Bullet does not update the contacts of an object that fell asleep and was then placed
        elsewhere, until the next step or :meth:`.Simulation.reset`.
        """
        return self._penetrates(self._scenery.movables[i], depth)

    def penetrating_pairs(self) -> list[tuple[str, str, str]]:
        """Return what penetrates at the current poses, each pair once.

        Returns
        -------
        list of (link, kind, name)
            A link of the robot's URDF, and "link" with another one, "fixture" or "object" with its
            number, or "floor" and "".
        """
        pybullet.performCollisionDetection(physicsClientId=self._client)
        me, colliders = self._robot.id, self._robot.colliders
        pairs = set()
        for point in pybullet.getContactPoints(me, physicsClientId=self._client):
            if point[8] >= 0:
                continue
            if point[1] == point[2]:
                first, second = sorted(colliders[number].source for number in point[3:5])
                pairs.add((first, "link", second))
                continue
            link, body = (point[3], point[2]) if point[1] == me else (point[4], point[1])
            pairs.add((colliders[link].source, *self._identify(body)))
        return sorted(pairs)

    def _identify(self, body: int) -> tuple[str, str]:
        if body in self._scenery.fixtures:
            return "fixture", str(self._scenery.fixtures[body])
        if body in self._scenery.movables:
            return "object", str(self._scenery.movables.index(body))
        return "floor", ""

    def clearance(self, max_distance: float, links: Collection[int] | None = None) -> float:
        """Return the distance from the robot to the nearest fixture or object.

        Parameters
        ----------
        max_distance : float
            Metres: the result is at most this.
        links : collection of int, optional
            Only from these links, numbered as in :class:`.body.Body`.
        """
        nearest, _ = self.nearest_fixture(max_distance, links)
        return min(nearest, self._nearest(self._scenery.movables, nearest, links)[0])

    def nearest_fixture(
        self, max_distance: float, links: Collection[int] | None = None
    ) -> tuple[float, int | None]:
        """Return the distance from the robot to the nearest fixture, and which it is.

        Parameters are those of :meth:`clearance`.

        Returns
        -------
        distance : float
            Metres; `max_distance` if no fixture is nearer.
        index : int or None
            Index in :attr:`.scene.Scene.fixtures`; None if no fixture is nearer.
        """
        distance, body = self._nearest(self._scenery.fixtures, max_distance, links)
        return distance, None if body is None else self._scenery.fixtures[body]

    def surface_below(self, x: float, y: float, z: float) -> float | None:
        """Return the height of the horizontal surface below a point, metres.

        Only the floor and fixtures count. None if there is no surface, or if a movable object or
        the robot is in between.
        """
        (hit,) = pybullet.rayTest((x, y, z), (x, y, _RAY_END), physicsClientId=self._client)
        body, position, normal = hit[0], hit[3], hit[4]
        static = body == self._scenery.floor or body in self._scenery.fixtures
        return float(position[2]) if static and normal[2] > _MIN_UPWARD else None

    def _penetrates(self, body: int, depth: float) -> bool:
        pybullet.performCollisionDetection(physicsClientId=self._client)
        points = pybullet.getContactPoints(body, physicsClientId=self._client)
        return any(point[8] < -depth for point in points)  # 8: distance

    def _nearest(
        self, bodies: Iterable[int], max_distance: float, links: Collection[int] | None
    ) -> tuple[float, int | None]:
        """Return the distance from the robot to the nearest of `bodies`, and which it is."""
        nearest, nearest_body = max_distance, None
        numbers = {
            number
            for number, collider in self._robot.colliders.items()
            if links is None or collider.link in links
        }
        for body in bodies:
            points = pybullet.getClosestPoints(
                self._robot.id, body, nearest, physicsClientId=self._client
            )
            for point in points:
                link, distance = point[3], point[8]
                if link in numbers and distance < nearest:
                    nearest, nearest_body = distance, body
        return nearest, nearest_body
