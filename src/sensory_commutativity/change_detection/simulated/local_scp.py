"""The local SCP: in how many of some SC-experiments at a place nothing immovable was in the way (paper, section IV-A).

Whether it was is decided by a mask predictor: both final pictures are *different*, or they are not, whatever movable things moved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...scp.experiment import REST_STEPS
from ...scp.sequences import compose, no_op, permute, sample_sequence
from ...scp.world import play
from ...worlds.apartment.world import ApartmentWorld
from ..outcome import outcome_of
from .photometric import apply_camera_noise, sample_light
from .poses import Pose
from .scene_sampler import displaced

TRIES = 30
"""How often joints are drawn at a place before it counts as one where the robot cannot stand; chosen: it is the base that is in the way, or
nothing."""


class Seen(NamedTuple):
    """The experiments at a place.

    Attributes
    ----------
    pictures : uint8 (n, 2, h, w, 3)
        The final ones of both orders.
    different : bool (n,)
        Whether they truly are.
    starts : float64 (n, joints)
        Where the joints began.
    """

    pictures: np.ndarray
    different: np.ndarray
    starts: np.ndarray


def experiments_at(
    place: Pose,
    world: ApartmentWorld,
    dof: int,
    length: int,
    experiments: int,
    rng: np.random.Generator,
) -> Seen | None:
    """Play SC-experiments of a degree of freedom at a place, each from its own pose of the joints; None where the robot cannot stand."""
    pictures, different, starts = [], [], []
    for _ in range(experiments):
        if not _stand(place, world, rng):
            return None
        starts.append(world.simulation.joints())
        start, sequence = world.snapshot(), sample_sequence(rng, length, dof, len(world.dofs))
        ends = [_end(world, start, order, rng) for order in (sequence, permute(rng, sequence))]
        (one, eye, poses), (other, other_eye, other_poses) = ends
        outcome, _ = outcome_of(
            one, other, eye, other_eye, displaced(poses, other_poses), world.cameras[0]
        )
        pictures.append(
            np.stack([apply_camera_noise(picture.rgb, rng) for picture in (one, other)])
        )
        different.append(outcome == "different")
    return Seen(np.stack(pictures), np.array(different), np.stack(starts))


def _stand(place: Pose, world: ApartmentWorld, rng: np.random.Generator) -> bool:
    simulation = world.simulation
    base = np.array([place.x, place.y, place.heading])
    for _ in range(TRIES):
        joints = simulation.robot.draw_joints(rng)
        simulation.place(base, joints)
        if not simulation.penetrates():
            simulation.place(base, joints)  # so that looking for contacts makes no difference
            simulation.settle()
            return True
    return False


def _end(world: ApartmentWorld, start, order: np.ndarray, rng: np.random.Generator):
    """How an order ends: picture, frame of the camera, poses of the objects."""
    world.restore(start)
    play(world, compose(order, no_op(REST_STEPS, order.shape[1])))
    simulation = world.simulation
    eye = simulation.eye_pose()
    return (
        world.renderer.render(world.cameras[0], eye, simulation.poses(), sample_light(rng)),
        eye,
        simulation.object_poses(),
    )
