"""A robot in a scene, simulated by PyBullet.

:class:`Simulation` composes the robot (:mod:`.simulated_robot`), the movable objects
(:mod:`.objects`), contact counts (:mod:`.contacts`), geometric queries (:mod:`.collisions`) and
snapshots (:mod:`.snapshots`). Rendering and the choice of start poses are elsewhere.
"""

from __future__ import annotations

import numpy as np

from ..bullet import pybullet
from ..robots.control import SUBSTEPS
from ..robots.robot import Robot
from ..scenes.scene import Scene
from ..scenes.scenery import build_scenery
from .bullet import BulletWorld
from .collisions import CollisionQueries
from .contacts import ContactCounter, ContactCounts
from .objects import MovableObjects
from .simulated_robot import SimulatedRobot
from .snapshots import SimulationSnapshot, restore_snapshot, take_snapshot

SETTLING = 960
"""Substeps (4 s) in which objects come to rest and fall asleep before the robot enters; chosen:
Bullet lets them sleep after 2 s."""
PARKED = (1000.0, 1000.0, 0.0)
"""Base pose of a robot outside the scene: x and y, metres, and heading."""


class Simulation:
    """A robot in a scene.

    Contacts are counted, and displacements of objects measured, since the robot was last placed
    or a snapshot restored, whichever is later.

    Parameters
    ----------
    scene : Scene
        Its movable objects come to rest first.
    robot : Robot

    Attributes
    ----------
    scene : Scene
    robot : Robot
    body : Body
        Kinematics, collision shapes and visuals of the robot.
    objects : MovableObjects
    collisions : CollisionQueries
    """

    def __init__(self, scene: Scene, robot: Robot):
        self.scene, self.robot = scene, robot
        self._world = BulletWorld()
        client = self._world.client
        scenery = build_scenery(client, scene)
        self._robot = SimulatedRobot(client, robot, scenery)
        self.body = self._robot.body
        self.objects = MovableObjects(client, scenery.movables)
        self.collisions = CollisionQueries(client, self._robot, scenery)
        self._contacts = ContactCounter(client, self._robot.id, scenery)
        self.place_robot(np.array(PARKED), robot.clip_joints(np.zeros(len(robot.joints))))
        self.wait(SETTLING)
        self.set_reset_state()

    def close(self) -> None:
        """Free PyBullet's memory. The simulation cannot be used afterwards."""
        self._world.close()

    # ---- poses -------------------------------------------------------------------------------

    def base(self) -> np.ndarray:
        """Return x, y (metres) and heading (rad, not wrapped) of the robot: float64 (3,)."""
        return self._robot.base()

    def joints(self) -> np.ndarray:
        """Return the positions of :attr:`.robots.robot.Robot.joints`: float64 (n,), rad or m."""
        return self._robot.joints()

    def camera_pose(self) -> np.ndarray:
        """Return the frame of the robot's camera, float64 (4, 4): x forward, y left, z up."""
        return self._robot.camera_pose()

    def poses(self) -> np.ndarray:
        """Return the frames of the world, the movable objects and the robot's links.

        float64 (1 + objects + links, 4, 4), in this order.
        """
        return np.concatenate([[np.eye(4)], self.objects.frames(), self._robot.link_poses()])

    # ---- placing -----------------------------------------------------------------------------

    def reset(self, base: np.ndarray, joints: np.ndarray) -> None:
        """Return all objects to where they settled, and place the robot at rest.

        Parameters
        ----------
        base : float64 (3,)
            x, y (metres) and heading (rad).
        joints : float64 (n,)
            Positions of :attr:`.robots.robot.Robot.joints`, rad or m; clipped to their limits.
        """
        self.restore(self._reset_state)
        self.place_robot(base, self.robot.clip_joints(joints))

    def set_reset_state(self) -> None:
        """From now on, :meth:`reset` returns the objects to where they are now."""
        self._reset_state = take_snapshot(self._world, self._robot, self.objects)

    def place_robot(self, base: np.ndarray, joints: np.ndarray) -> None:
        """Place the robot at rest, without clipping, and leave the objects where they are."""
        self._robot.place(base, joints)
        self._start_recording(self.objects.positions())

    def fits(self, base: np.ndarray, joints: np.ndarray) -> bool:
        """Place the robot as :meth:`place_robot` and return whether it penetrates nothing there.

        If it does, counts and displacements are not reset, so trying many poses is fast.
        """
        self._robot.place(base, joints)
        free = not self.collisions.robot_penetrates()
        if free:
            self._start_recording(self.objects.positions())
        return free

    # ---- motion ------------------------------------------------------------------------------

    def step(self, action: np.ndarray) -> None:
        """Play an action for 0.1 s: float (dofs,), clipped to [-1, 1].

        Raises
        ------
        ValueError
            The action has another shape, or values that are not finite.
        """
        self._robot.start_action(np.asarray(action, np.float64))
        for substep in range(SUBSTEPS):
            at_limit = self._run_substep(substep)
            self._contacts.record_substep(at_limit)
        self._contacts.end_step()

    def settle(self) -> None:
        """Play an action of zeros, so that the motors carry their loads, and reset the counts."""
        self.step(np.zeros(len(self.robot.dofs)))
        self._start_recording(self.objects.positions())

    def wait(self, substeps: int) -> None:
        """Simulate some substeps of 1/240 s while the robot holds still; contacts do not count."""
        for substep in range(substeps):
            self._run_substep(substep % SUBSTEPS)

    def contact_counts(self) -> ContactCounts:
        """Return in how many steps the robot touched something."""
        return self._contacts.counts()

    # ---- snapshots ---------------------------------------------------------------------------

    def snapshot(self) -> SimulationSnapshot:
        """Return a snapshot; from here the simulation continues exactly as after restoring it."""
        snapshot = take_snapshot(self._world, self._robot, self.objects)
        self.restore(snapshot)
        return snapshot

    def restore(self, snapshot: SimulationSnapshot) -> None:
        """Return to a snapshot of this simulation.

        Raises
        ------
        ValueError
            The snapshot is of another simulation.
        """
        restore_snapshot(snapshot, self._world, self._robot, self.objects)
        self._start_recording(snapshot.object_positions)

    def _run_substep(self, substep: int) -> bool:
        """Simulate 1/240 s; return whether a limit stops a joint."""
        at_limit = self._robot.drive(substep)
        pybullet.stepSimulation(physicsClientId=self._world.client)
        return at_limit

    def _start_recording(self, object_positions: np.ndarray) -> None:
        self._contacts.reset()
        self.objects.set_reference(object_positions)
