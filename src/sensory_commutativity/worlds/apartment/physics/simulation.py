"""A robot in a scene, on PyBullet: placing it, moving it, putting everything back, and telling what it touched.

Every simulation is a PyBullet world of its own, without a window. Nothing here draws or chooses: :mod:`.camera` sees, :mod:`.starts` chooses
where to start.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pybullet

from .. import frames as fr
from ..robots.body import BASE_JOINTS, Collider, build_body
from ..robots.control import DT, SUBSTEPS, advance, at_rest, begin, law_of
from ..robots.robot import Robot
from ..scenes.scene import Scene
from ..scenes.scenery import FRICTION, build_scenery
from .states import BulletWorld, Situation, State

GRAVITY = 9.81
ITERATIONS = 30
"""Of the contact and motor solver, of which the control corrects what is left over (PyBullet's default is 50). Measured: idle joints stay within
1e-5 rad."""
SETTLING = 960
"""Substeps (4 s) in which objects come to rest and fall asleep, before any robot comes; chosen: Bullet lets them sleep after 2 s."""
_AWAKE = pybullet.ACTIVATION_STATE_WAKE_UP
_ASLEEP = (
    pybullet.ACTIVATION_STATE_WAKE_UP | pybullet.ACTIVATION_STATE_SLEEP
)  # waking first sets the time at rest back
_APART = 50.0  # metres between things that must not touch
PARKED = (1000.0, 1000.0, 0.0)
"""Where a robot is while it is nowhere: x and y, metres, and heading."""


class ContactCounts(NamedTuple):
    """In how many control steps the robot touched what, if only for a moment, since it was last put somewhere."""

    steps: int
    fixed: int  # a fixture, or the floor with anything but its base and wheels
    movable: int
    itself: int
    at_limit: int  # a joint was commanded beyond its limit


class Simulation:
    """A robot in a scene.

    Parameters
    ----------
    scene : Scene
        Its movable objects come to rest before anything else happens.
    robot : Robot

    Attributes
    ----------
    scene, robot
        As given.
    body : Body
        The simulated robot: what of it is seen, and where.
    """

    def __init__(self, scene: Scene, robot: Robot):
        self.scene, self.robot = scene, robot
        self.body = build_body(robot)
        self._law, forces = law_of(robot)
        self._forces = forces.tolist()
        self._camera = self._camera_mount()
        self._world = BulletWorld()
        self._client = client = self._world.client
        pybullet.setTimeStep(DT, physicsClientId=client)
        pybullet.setGravity(0, 0, -GRAVITY, physicsClientId=client)
        pybullet.setPhysicsEngineParameter(
            numSolverIterations=ITERATIONS, deterministicOverlappingPairs=1, physicsClientId=client
        )
        self._scenery = build_scenery(client, scene)
        self._add_robot()
        self._touched = np.zeros(len(ContactCounts._fields), np.int64)
        self._told = np.zeros(len(self._axes))
        self.put_robot(np.array(PARKED), np.clip(0.0, robot.limits[:, 0], robot.limits[:, 1]))
        for _ in range(SETTLING):
            self._substep(0)
        self._settled = self._take()

    def close(self) -> None:
        """Give back what PyBullet holds. The simulation cannot be used any more."""
        self._world.close()

    # ---- situations ------------------------------------------------------------------------------------------------------

    def place(self, base: np.ndarray, joints: np.ndarray) -> None:
        """Put the robot somewhere, at rest, and all objects back to where they settled.

        Parameters
        ----------
        base : float64 (3,)
            x, y (metres) and heading (rad).
        joints : float64 (n,)
            Positions of :attr:`.robot.Robot.joints`, rad or m; clipped to their limits.
        """
        self.restore(self._settled)
        self.put_robot(base, np.clip(joints, self.robot.limits[:, 0], self.robot.limits[:, 1]))

    def put_robot(self, base: np.ndarray, joints: np.ndarray) -> None:
        """As :meth:`place`, but leave the objects where they are, and clip nothing."""
        self._put_robot(base, joints)
        self._begin_record(self._object_positions())

    def fits(self, base: np.ndarray, joints: np.ndarray) -> bool:
        """:meth:`put_robot`, and whether it is inside nothing there; if it is, nothing is counted anew, so that trying many places is quick."""
        self._put_robot(base, joints)
        free = not self.penetrates()
        if free:
            self._begin_record(self._object_positions())
        return free

    def _put_robot(self, base: np.ndarray, joints: np.ndarray) -> None:
        x, y, heading = (float(value) for value in base)
        positions = [float(value) for value in joints]
        if self.robot.wheels:
            positions = [x, y, heading, *positions]
        else:
            rotation = pybullet.getQuaternionFromEuler((0, 0, heading))
            pybullet.resetBasePositionAndOrientation(
                self._robot, (x, y, 0), rotation, physicsClientId=self._client
            )
        for axis, position in zip(self._axes, positions, strict=True):
            pybullet.resetJointState(self._robot, axis, position, 0.0, physicsClientId=self._client)
        self._place = np.array([x, y, heading])
        self._control = at_rest(self._law, np.array(positions))

    def keep_objects(self) -> None:
        """From now on :meth:`place` puts the objects where they are at this moment."""
        self._settled = self._take()

    def settle(self) -> None:
        """Let a control step go by without a command, so that the motors carry what they have to, and begin counting anew."""
        self.step(np.zeros(len(self._law.velocity)))
        self._begin_record(self._object_positions())

    def snapshot(self) -> Situation:
        """Return the present situation; afterwards this simulation goes on exactly as one restored from it does."""
        situation = self._take()
        self.restore(situation)
        return situation

    def restore(self, situation: Situation) -> None:
        """Put everything back. Counting of touches and displacements begins anew."""
        if situation.state.world is not self._world:
            raise ValueError("the situation is of another simulation")
        self._recall(situation)
        self._control.set(situation.control)
        self._place = situation.place.copy()
        self._begin_record(situation.origins)

    # ---- motion ----------------------------------------------------------------------------------------------------------

    def step(self, action: np.ndarray) -> None:
        """Play one action: float64 (dofs,), clipped to [-1, 1]."""
        action = np.asarray(action, np.float64)
        if action.shape != self._law.velocity.shape:
            raise ValueError(
                f"an action has {len(self._law.velocity)} elements, one per degree of freedom; got an array of shape {action.shape}"
            )
        if not np.isfinite(action).all():
            raise ValueError("an action holds a value that is not finite; actions lie in [-1, 1]")
        begin(self._law, self._control, action)
        events = 0
        for substep in range(SUBSTEPS):
            events |= self._substep(substep)
        self._touched += [1, *(events >> np.arange(len(ContactCounts._fields) - 1) & 1)]

    # ---- what is -----------------------------------------------------------------------------------------------------------

    def base(self) -> np.ndarray:
        """x, y (metres) and heading (rad, not wrapped) of the robot: float64 (3,)."""
        return self._measured()[:3] if self.robot.wheels else self._place.copy()

    def joints(self) -> np.ndarray:
        """Positions of :attr:`.robot.Robot.joints`: float64 (n,), rad or m."""
        measured = self._measured()
        return measured[3:] if self.robot.wheels else measured

    def poses(self) -> np.ndarray:
        """Frames of the world, of the movable objects and of the robot's links, in this order: float64 (1 + movables + links, 4, 4)."""
        objects = [
            pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
            for body in self._scenery.movables
        ]
        return np.concatenate(
            [[np.eye(4)], *([fr.from_quaternion(*pose)] for pose in objects), self._link_poses()]
        )

    def eye_pose(self) -> np.ndarray:
        """Frame of the camera, float64 (4, 4): x is where it looks, y left, z up."""
        link, mount = self._camera
        return self._link_poses()[link] @ mount

    def touches(self) -> ContactCounts:
        """What the robot has touched since it was put somewhere."""
        return ContactCounts(*self._touched.tolist())

    def object_shifts(self) -> np.ndarray:
        """How far each movable object is from where it was when the robot was put somewhere: float64 (movables,), metres."""
        return np.linalg.norm(self._object_positions() - self._origins, axis=1)

    def penetrates(self, depth: float = 0.0) -> bool:
        """Whether the robot is inside something, or inside itself, by more than `depth` metres."""
        pybullet.performCollisionDetection(physicsClientId=self._client)
        return any(
            point[8] < -depth
            for point in pybullet.getContactPoints(self._robot, physicsClientId=self._client)
        )

    def clearance(self, most: float, links: Collection[int] | None = None) -> float:
        """Metres from the robot, or some of its links (numbers as in :class:`.body.Body`), to the nearest thing; at most `most`."""
        nearest, _ = self.nearest_fixture(most, links)
        return min(nearest, self._nearest(self._scenery.movables, nearest, links)[0])

    def nearest_fixture(
        self, most: float, links: Collection[int] | None = None
    ) -> tuple[float, int | None]:
        """The same of fixtures alone, and the number of the nearest one in the scene; None if there is none within `most`."""
        nearest, body = self._nearest(self._scenery.fixtures, most, links)
        return nearest, None if body is None else self._scenery.fixtures[body]

    # ---- objects by hand --------------------------------------------------------------------------------------------------

    def object_poses(self) -> np.ndarray:
        """Where the movable objects are: float64 (movables, 7), place and rotation (x, y, z, w)."""
        poses = [
            pybullet.getBasePositionAndOrientation(body, physicsClientId=self._client)
            for body in self._scenery.movables
        ]
        return np.array([(*place, *turn) for place, turn in poses]).reshape(-1, 7)

    def put_object(
        self,
        i: int,
        pose: np.ndarray,
        velocity: Sequence[float] = (0, 0, 0),
        spin: Sequence[float] = (0, 0, 0),
    ) -> None:
        """Put the i-th movable object somewhere, float64 (7,), at rest or in motion, m/s and rad/s."""
        body = self._scenery.movables[i]
        pybullet.resetBasePositionAndOrientation(
            body, pose[:3].tolist(), pose[3:].tolist(), physicsClientId=self._client
        )
        pybullet.resetBaseVelocity(body, list(velocity), list(spin), physicsClientId=self._client)
        pybullet.changeDynamics(body, -1, activationState=_AWAKE, physicsClientId=self._client)

    def surface_below(self, x: float, y: float, z: float) -> float | None:
        """Height of what carries things below a point, metres; None where there is nothing, or another movable object or the robot is in between."""
        (hit,) = pybullet.rayTest((x, y, z), (x, y, -0.5), physicsClientId=self._client)
        carries = hit[0] == self._scenery.floor or hit[0] in self._scenery.fixtures
        return float(hit[3][2]) if carries and hit[4][2] > 0.99 else None

    def object_penetrates(self, i: int, depth: float = 0.003) -> bool:
        """Whether the i-th movable object is inside something by more than `depth` metres."""
        body = self._scenery.movables[i]
        pybullet.performCollisionDetection(physicsClientId=self._client)
        return any(
            point[8] < -depth
            for point in pybullet.getContactPoints(body, physicsClientId=self._client)
        )

    def wait(self, substeps: int) -> None:
        """Let time go by, 1/240 s each, while the robot holds still."""
        for substep in range(substeps):
            self._substep(substep % SUBSTEPS)

    # ---- inside ------------------------------------------------------------------------------------------------------------

    def _substep(self, substep: int) -> int:
        """Run on by 1/240 s; returns a bit for each thing touched, in the order of ContactCounts from `fixed` on."""
        at_limit = advance(self._law, self._control, substep, self._measured(), self._told)
        pybullet.setJointMotorControlArray(
            self._robot,
            self._axes,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=self._told.tolist(),
            forces=self._forces,
            physicsClientId=self._client,
        )
        pybullet.stepSimulation(physicsClientId=self._client)
        events = 8 * at_limit
        for point in pybullet.getContactPoints(self._robot, physicsClientId=self._client):
            if point[9] > 0:  # pressed, not only near
                events |= self._bit_of[point[2] if point[1] == self._robot else point[1]]
        return events

    def _nearest(
        self, bodies: Iterable[int], most: float, links: Collection[int] | None
    ) -> tuple[float, int | None]:
        """Distance from the robot's links to the nearest of PyBullet's `bodies`, at most `most`, and which it is."""
        nearest, found = most, None
        wanted = (
            None
            if links is None
            else {number for number, collider in self._colliders.items() if collider.link in links}
        )
        for body in bodies:
            for point in pybullet.getClosestPoints(
                self._robot, body, nearest, physicsClientId=self._client
            ):
                if (wanted is None or point[3] in wanted) and point[8] < nearest:
                    nearest, found = point[8], body
        return nearest, found

    def _measured(self) -> np.ndarray:
        return np.array(
            [
                state[0]
                for state in pybullet.getJointStates(
                    self._robot, self._axes, physicsClientId=self._client
                )
            ]
        )

    def _take(self) -> Situation:
        velocities = [
            pybullet.getBaseVelocity(body, physicsClientId=self._client)
            for body in self._scenery.movables
        ]
        asleep = tuple(
            not any(linear) and not any(angular) for linear, angular in velocities
        )  # what sleeps has no velocity at all
        return Situation(
            State(self._world),
            self._control.copy(),
            self._place.copy(),
            self._object_positions(),
            asleep,
        )

    def _recall(self, situation: Situation) -> None:
        """Put PyBullet's world back so that whatever was there before makes no difference.

        PyBullet restores neither which objects sleep nor, reliably, contacts: what is left in its cache of contacts depends on what happened
        before. So everything that moves is first taken so far apart that nothing touches, which empties the cache. Then all is restored, awake,
        and run on by a step, whereby contacts are found anew; restored once more, and objects are laid to sleep, for as long as before.
        """
        for i, body in enumerate(self._scenery.movables):
            pybullet.resetBasePositionAndOrientation(
                body, (_APART * (i + 2), _APART, _APART), (0, 0, 0, 1), physicsClientId=self._client
            )
            pybullet.changeDynamics(body, -1, activationState=_AWAKE, physicsClientId=self._client)
        if self.robot.wheels:
            pybullet.resetJointState(
                self._robot, self._axes[0], _APART, 0.0, physicsClientId=self._client
            )
        else:
            pybullet.resetBasePositionAndOrientation(
                self._robot, (-_APART, 0, 0), (0, 0, 0, 1), physicsClientId=self._client
            )
        pybullet.performCollisionDetection(physicsClientId=self._client)
        pybullet.restoreState(situation.state.number, physicsClientId=self._client)
        pybullet.stepSimulation(physicsClientId=self._client)
        pybullet.restoreState(situation.state.number, physicsClientId=self._client)
        for body, sleeps in zip(self._scenery.movables, situation.asleep, strict=True):
            pybullet.changeDynamics(
                body,
                -1,
                activationState=_ASLEEP if sleeps else _AWAKE,
                physicsClientId=self._client,
            )

    def _begin_record(self, origins: np.ndarray) -> None:
        self._touched[:] = 0
        self._origins = origins

    def _object_positions(self) -> np.ndarray:
        return self.object_poses()[:, :3]

    def _link_poses(self) -> np.ndarray:
        return self.body.link_poses(self.base(), self.joints())

    def _camera_mount(self) -> tuple[int, np.ndarray]:
        camera = self.robot.description.camera
        link, frame = self.body.where[camera.link]
        return link, frame @ fr.from_rpy(tuple(camera.position), tuple(camera.rotation))  # type: ignore[arg-type]

    def _add_robot(self) -> None:
        client = self._client
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_SELF_COLLISION
        self._robot = robot = pybullet.loadURDF(
            str(self.body.urdf), useFixedBase=True, flags=flags, physicsClientId=client
        )
        about = [
            pybullet.getJointInfo(robot, i, physicsClientId=client)
            for i in range(pybullet.getNumJoints(robot, physicsClientId=client))
        ]
        joint, link = ({entry[column].decode(): entry[0] for entry in about} for column in (1, 12))
        moving = [f"joint-{i + 1}" for i in range(len(self.robot.joints))]
        self._axes = [
            joint[name] for name in ((*BASE_JOINTS, *moving) if self.robot.wheels else moving)
        ]
        self._colliders = {link[collider.name]: collider for collider in self.body.colliders}
        for number in range(-1, len(about)):
            pybullet.changeDynamics(
                robot, number, linearDamping=0, angularDamping=0, jointDamping=0, lateralFriction=FRICTION**0.5,
                activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING, physicsClientId=client,
            )  # fmt: skip
        for (a, one), (b, other) in combinations(self._colliders.items(), 2):
            if self._pass(one, other):
                pybullet.setCollisionFilterPair(robot, robot, a, b, 0, physicsClientId=client)
        scenery = self._scenery
        for number, collider in self._colliders.items():
            if (
                scenery.floor is not None and collider.link == 0
            ):  # the base is carried by its joints; the floor too would over-determine it
                pybullet.setCollisionFilterPair(
                    robot, scenery.floor, number, -1, 0, physicsClientId=client
                )
        self._bit_of = {
            robot: 4,
            **dict.fromkeys(scenery.fixtures, 1),
            **dict.fromkeys(scenery.movables, 2),
        }
        if scenery.floor is not None:
            self._bit_of[scenery.floor] = 1

    def _pass(self, one: Collider, other: Collider) -> bool:
        """Whether two collision shapes of the robot pass through each other: those of the same link, of neighbours, and those declared to."""
        parents = self.body.parents
        near = (
            one.link == other.link
            or parents[one.link] == other.link
            or parents[other.link] == one.link
        )
        return near or any(
            {one.origin, other.origin} == set(pair) for pair in self.robot.description.passing
        )
