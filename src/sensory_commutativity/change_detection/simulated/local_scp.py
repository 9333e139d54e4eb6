"""SC-experiments for the local SCP: how often nothing immovable is in the way at a pose of the
robot (paper, section IV-A).

A mask predictor decides it later from the final pictures of both orders: the outcome is
*different*, or it is not, whichever movable objects moved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...scp.experiment import REST_STEPS, compare_orders
from ...scp.sequences import permute, sample_sequence
from ...worlds.apartment.rendering.camera import Picture
from ...worlds.apartment.world import ApartmentWorld
from ..outcome import displaced_objects, label_pair
from .photometric import apply_camera_noise, sample_light
from .poses import Pose

JOINT_TRIES = 30
"""Joint configurations that are tried before a pose counts as occupied. Chosen: what is in the way
is nearly always in the way of the base, which does not depend on the joints."""


class LocalExperiments(NamedTuple):
    """n experiments at one pose of the robot's base.

    Attributes
    ----------
    pictures : uint8 (n, 2, h, w, 3)
        Final picture of either order.
    different : bool (n,)
        Whether the true outcome is *different*.
    starts : float64 (n, joints)
        Joint positions at the start, rad or m.
    """

    pictures: np.ndarray
    different: np.ndarray
    starts: np.ndarray


class _Ending(NamedTuple):
    """What is recorded at the end of an order."""

    picture: Picture
    camera_pose: np.ndarray  # float64 (4, 4)
    object_poses: np.ndarray  # float64 (objects, 7)


def play_local_experiments(
    pose: Pose,
    world: ApartmentWorld,
    dof: int,
    length: int,
    experiments: int,
    rng: np.random.Generator,
    rest_steps: int = REST_STEPS,
) -> LocalExperiments | None:
    """Play SC-experiments with one degree of freedom at a pose, each from random joint positions.

    Parameters
    ----------
    pose : Pose
    world : ApartmentWorld
        Its first camera takes the pictures.
    dof : int
        Index of the degree of freedom.
    length : int
        Number of actions in a sequence.
    experiments : int
        Number of experiments.
    rng : numpy.random.Generator
    rest_steps : int
        Steps without a command that end each order.

    Returns
    -------
    LocalExperiments or None
        None if the robot cannot stand there without contact.
    """
    simulation, camera = world.simulation, world.cameras[0]

    def observe() -> _Ending:
        camera_pose = simulation.camera_pose()
        picture = world.renderer.render(camera, camera_pose, simulation.poses(), sample_light(rng))
        return _Ending(picture, camera_pose, simulation.objects.poses())

    pictures, different, starts = [], [], []
    for _ in range(experiments):
        if not _place_robot(pose, world, rng):
            return None
        starts.append(simulation.joints())
        start = world.snapshot()
        sequence = sample_sequence(rng, length, dof, len(world.dofs))
        permuted = permute(rng, sequence)
        a, b = compare_orders(world, start, sequence, permuted, rest_steps, observe)
        displaced = displaced_objects(a.object_poses, b.object_poses)
        outcome, _ = label_pair(
            a.picture, b.picture, a.camera_pose, b.camera_pose, displaced, camera
        )
        pictures.append(np.stack([apply_camera_noise(end.picture.rgb, rng) for end in (a, b)]))
        different.append(outcome == "different")
    return LocalExperiments(np.stack(pictures), np.array(different), np.stack(starts))


def _place_robot(pose: Pose, world: ApartmentWorld, rng: np.random.Generator) -> bool:
    """Place the robot at rest with random joint positions; False if it always touches something."""
    simulation = world.simulation
    base = np.array([pose.x, pose.y, pose.heading])
    for _ in range(JOINT_TRIES):
        joints = simulation.robot.draw_joints(rng)
        simulation.reset(base, joints)
        if not simulation.collisions.robot_penetrates():
            simulation.reset(base, joints)  # the collision query must leave no trace
            simulation.settle()
            return True
    return False
