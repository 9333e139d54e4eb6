"""The robot in PyBullet: its pose, its motors and what drives them."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from .. import frames as fr
from ..bullet import pybullet
from ..robots.body import build_body
from ..robots.bullet_urdf import BASE_JOINTS, Collider
from ..robots.control import ControllerState, advance, hold_still, make_controller, start_action
from ..robots.robot import Robot
from ..scenes.scenery import FRICTION, Scenery


class SimulatedRobot:
    """A robot in a PyBullet world.

    Its axes are x, y and heading of the base, if it has a drive, and then the joints.

    Parameters
    ----------
    client : int
        PyBullet's number of the world.
    robot : Robot
    scenery : Scenery

    Attributes
    ----------
    robot : Robot
    body : Body
        Its kinematics, collision shapes and visuals.
    id : int
        PyBullet's number of it.
    colliders : dict
        PyBullet's number of a link -> its collision shape.
    controller : ControllerState
    placed_at : float64 (3,)
        Base pose where it was last placed. Without a drive it stays there.
    """

    controller: ControllerState
    placed_at: np.ndarray

    def __init__(self, client: int, robot: Robot, scenery: Scenery):
        self.robot, self.body = robot, build_body(robot)
        self._client = client
        self._parameters, forces = make_controller(robot)
        self._forces = forces.tolist()
        self._camera_link, self._camera_frame = self._mount_camera()
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_SELF_COLLISION
        self.id = pybullet.loadURDF(
            str(self.body.urdf), useFixedBase=True, flags=flags, physicsClientId=client
        )
        n_joints = pybullet.getNumJoints(self.id, physicsClientId=client)
        infos = [pybullet.getJointInfo(self.id, i, physicsClientId=client) for i in range(n_joints)]
        joint_number, link_number = ({info[k].decode(): info[0] for info in infos} for k in (1, 12))
        joints = [f"joint-{i + 1}" for i in range(len(robot.joints))]
        axes = [*BASE_JOINTS, *joints] if robot.wheels else joints
        self._axes = [joint_number[name] for name in axes]
        self.colliders = {link_number[collider.name]: collider for collider in self.body.colliders}
        self._velocity_target = np.zeros(len(self._axes))
        self._set_dynamics(n_joints)
        self._filter_collisions(scenery)

    # ---- pose --------------------------------------------------------------------------------

    def place(self, base: np.ndarray, joints: np.ndarray) -> None:
        """Place the robot at rest.

        Parameters
        ----------
        base : float64 (3,)
            x, y (metres) and heading (rad).
        joints : float64 (n,)
            Positions of :attr:`.robots.robot.Robot.joints`, rad or m.
        """
        x, y, heading = (float(value) for value in base)
        positions = [float(value) for value in joints]
        if self.robot.wheels:
            positions = [x, y, heading, *positions]
        else:
            rotation = pybullet.getQuaternionFromEuler((0, 0, heading))
            pybullet.resetBasePositionAndOrientation(
                self.id, (x, y, 0), rotation, physicsClientId=self._client
            )
        for axis, position in zip(self._axes, positions, strict=True):
            pybullet.resetJointState(self.id, axis, position, 0.0, physicsClientId=self._client)
        self.placed_at = np.array([x, y, heading])
        self.controller = hold_still(self._parameters, np.array(positions))

    def move_away(self, distance: float) -> None:
        """Move the robot by `distance` metres from the origin, for :func:`.restore_snapshot`."""
        if self.robot.wheels:
            pybullet.resetJointState(
                self.id, self._axes[0], distance, 0.0, physicsClientId=self._client
            )
        else:
            pybullet.resetBasePositionAndOrientation(
                self.id, (-distance, 0, 0), (0, 0, 0, 1), physicsClientId=self._client
            )

    def base(self) -> np.ndarray:
        """Return x, y (metres) and heading (rad, not wrapped): float64 (3,)."""
        return self._measure()[:3] if self.robot.wheels else self.placed_at.copy()

    def joints(self) -> np.ndarray:
        """Return the positions of :attr:`.robots.robot.Robot.joints`: float64 (n,), rad or m."""
        measured = self._measure()
        return measured[3:] if self.robot.wheels else measured

    def link_poses(self) -> np.ndarray:
        """Return the frames of the links of :class:`.robots.body.Body`: float64 (links, 4, 4)."""
        return self.body.link_poses(self.base(), self.joints())

    def camera_pose(self) -> np.ndarray:
        """Return the frame of the camera, float64 (4, 4): x forward, y left, z up."""
        return self.link_poses()[self._camera_link] @ self._camera_frame

    # ---- motion ------------------------------------------------------------------------------

    def start_action(self, action: np.ndarray) -> None:
        """Command an action, float64 (dofs,), clipped to [-1, 1].

        Raises
        ------
        ValueError
            Its shape is not (dofs,), or it contains values that are not finite.
        """
        n_dofs = len(self._parameters.dof_velocity)
        if action.shape != (n_dofs,):
            raise ValueError(
                f"an action has {n_dofs} elements, one per degree of freedom; "
                f"got an array of shape {action.shape}"
            )
        if not np.isfinite(action).all():
            raise ValueError(
                "an action contains values that are not finite; give values in [-1, 1]"
            )
        start_action(self._parameters, self.controller, action)

    def drive(self, substep: int) -> bool:
        """Set the motors for a substep of the action; return whether a limit stops an axis."""
        at_limit = advance(
            self._parameters, self.controller, substep, self._measure(), self._velocity_target
        )
        pybullet.setJointMotorControlArray(
            self.id,
            self._axes,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=self._velocity_target.tolist(),
            forces=self._forces,
            physicsClientId=self._client,
        )
        return at_limit

    def _measure(self) -> np.ndarray:
        """Return the positions of the axes: float64 (axes,)."""
        states = pybullet.getJointStates(self.id, self._axes, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    # ---- construction ------------------------------------------------------------------------

    def _mount_camera(self) -> tuple[int, np.ndarray]:
        """Return the link that carries the camera and the camera's frame in it."""
        camera = self.robot.description.camera
        link, frame = self.body.source_links[camera.link]
        (x, y, z), (roll, pitch, yaw) = camera.position, camera.rotation
        return link, frame @ fr.from_rpy((x, y, z), (roll, pitch, yaw))

    def _set_dynamics(self, n_links: int) -> None:
        for link in range(-1, n_links):
            pybullet.changeDynamics(
                self.id,
                link,
                linearDamping=0,
                angularDamping=0,
                jointDamping=0,
                lateralFriction=FRICTION**0.5,  # PyBullet multiplies the values of two bodies
                activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
                physicsClientId=self._client,
            )

    def _filter_collisions(self, scenery: Scenery) -> None:
        """Disable collisions within the robot where shapes overlap, and of the base with the floor.

        The base is carried by its joints; the floor would over-determine it.
        """
        client = self._client
        for (a, first), (b, second) in combinations(self.colliders.items(), 2):
            if self._may_overlap(first, second):
                pybullet.setCollisionFilterPair(self.id, self.id, a, b, 0, physicsClientId=client)
        if scenery.floor is None:
            return
        for number, collider in self.colliders.items():
            if collider.link == 0:
                pybullet.setCollisionFilterPair(
                    self.id, scenery.floor, number, -1, 0, physicsClientId=client
                )

    def _may_overlap(self, first: Collider, second: Collider) -> bool:
        """Return whether shapes are of one link or of neighbours, or are declared as passing."""
        a, b, parents = first.link, second.link, self.body.parents
        if a == b or parents[a] == b or parents[b] == a:
            return True
        sources = {first.source, second.source}
        return any(sources == set(pair) for pair in self.robot.description.passing)
