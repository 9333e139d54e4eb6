"""The movable objects in PyBullet: where they are, and placing them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .. import frames as fr
from ..bullet import pybullet
from ..scenes.scene import Quaternion, Vector

_AWAKE = pybullet.ACTIVATION_STATE_WAKE_UP
# Waking first resets the time that the object has been at rest.
_ASLEEP = pybullet.ACTIVATION_STATE_WAKE_UP | pybullet.ACTIVATION_STATE_SLEEP


class MovableObjects:
    """The movable objects of a scene, numbered as in :attr:`.scene.Scene.movables`.

    Parameters
    ----------
    client : int
        PyBullet's number of the world.
    bodies : sequence of int
        PyBullet's numbers of the objects.
    """

    def __init__(self, client: int, bodies: Sequence[int]):
        self._client, self.bodies = client, tuple(bodies)
        self._reference = self.positions()

    def poses(self) -> np.ndarray:
        """Return positions and rotations (x, y, z, w): float64 (objects, 7)."""
        poses = [(*position, *rotation) for position, rotation in self._poses()]
        return np.array(poses, np.float64).reshape(-1, 7)

    def frames(self) -> np.ndarray:
        """Return the poses as frames: float64 (objects, 4, 4)."""
        return np.array([fr.from_quaternion(*pose) for pose in self._poses()]).reshape(-1, 4, 4)

    def positions(self) -> np.ndarray:
        """Return the positions: float64 (objects, 3), metres."""
        return self.poses()[:, :3]

    def place(
        self,
        i: int,
        pose: np.ndarray,
        velocity: Sequence[float] | np.ndarray = (0, 0, 0),
        spin: Sequence[float] | np.ndarray = (0, 0, 0),
    ) -> None:
        """Place an object.

        Parameters
        ----------
        i : int
            Its number.
        pose : float64 (7,)
            Position, metres, and rotation (x, y, z, w).
        velocity, spin : float (3,)
            Linear velocity, m/s, and angular velocity, rad/s.
        """
        body, client = self.bodies[i], self._client
        pybullet.resetBasePositionAndOrientation(
            body, pose[:3].tolist(), pose[3:].tolist(), physicsClientId=client
        )
        pybullet.resetBaseVelocity(body, list(velocity), list(spin), physicsClientId=client)
        pybullet.changeDynamics(body, -1, activationState=_AWAKE, physicsClientId=client)

    def separate(self, distance: float) -> None:
        """Move all objects, awake, at least `distance` metres from each other and the origin."""
        for i, body in enumerate(self.bodies):
            position = (distance * (i + 2), distance, distance)
            pybullet.resetBasePositionAndOrientation(
                body, position, (0, 0, 0, 1), physicsClientId=self._client
            )
            pybullet.changeDynamics(body, -1, activationState=_AWAKE, physicsClientId=self._client)

    def asleep(self) -> tuple[bool, ...]:
        """Return which objects Bullet has put to sleep: only they have no velocity at all."""
        velocities = [
            pybullet.getBaseVelocity(body, physicsClientId=self._client) for body in self.bodies
        ]
        return tuple(not any(linear) and not any(angular) for linear, angular in velocities)

    def set_asleep(self, asleep: Sequence[bool]) -> None:
        """Put these objects to sleep and wake the others."""
        for body, sleeps in zip(self.bodies, asleep, strict=True):
            state = _ASLEEP if sleeps else _AWAKE
            pybullet.changeDynamics(body, -1, activationState=state, physicsClientId=self._client)

    def set_reference(self, positions: np.ndarray) -> None:
        """Measure displacements from these positions: float64 (objects, 3), metres."""
        self._reference = positions

    def displacements(self) -> np.ndarray:
        """Return how far each object is from its reference position: float64 (objects,), metres."""
        return np.linalg.norm(self.positions() - self._reference, axis=1)

    def _poses(self) -> list[tuple[Vector, Quaternion]]:
        return [
            pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
            for body in self.bodies
        ]
