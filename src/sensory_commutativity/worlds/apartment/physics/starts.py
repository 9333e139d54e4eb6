"""Random valid start situations: where a robot may begin, and how close to things its arm is there (paper, section III-B)."""

from __future__ import annotations

import math

import numpy as np

from ....errors import UserError
from .simulation import PARKED, Simulation

FAR = 1.0
"""Metres: clearances are measured up to here."""
TRIES = 5_000
"""Places that are tried before a start counts as not to be found; chosen: about 20 s, and a hundred times what the stand-ins need."""


class StartError(UserError):
    """No valid start situation can be found."""


def arm_links(simulation: Simulation) -> tuple[int, ...]:
    """The links that joints turn, which neither the base nor a lift is: numbers as in :class:`.body.Body`."""
    return tuple(
        i for i, joint in enumerate(simulation.robot.joints, start=1) if joint.kind != "prismatic"
    )


def draw_start(
    simulation: Simulation,
    rng: np.random.Generator,
    within: float | None = None,
    tries: int | None = None,
) -> float:
    """Put the robot into a random valid situation, at rest.

    The place is uniform over the scene's areas and the heading over all directions; joints are drawn from the robot's start ranges. What makes the
    robot touch anything, or itself, is drawn anew, all of it, so that valid situations stay as likely as each other.

    Parameters
    ----------
    simulation : Simulation
    rng : numpy.random.Generator
    within : float, optional
        Metres: something has to be nearer to the arm than this.
    tries : int, optional
        How often to draw at most; TRIES if not given.

    Returns
    -------
    float
        Metres from the arm to the nearest fixture or object; at most 1.

    Raises
    ------
    StartError
        No draw was valid.
    """
    arm, robot = arm_links(simulation), simulation.robot.description.name
    if within is not None and not arm:
        raise StartError(
            f"robot {robot!r} has no joint that turns, so nothing is within its reach; let it start anywhere"
        )
    tries = tries or TRIES
    left, touching = tries, 0
    while left > 0:
        drawn, found = _draw(simulation, rng, left)
        left, touching = left - drawn, touching + drawn - found
        if not found:
            break
        simulation.place(
            simulation.base(), simulation.joints()
        )  # so that what was tried before makes no difference
        clearance = simulation.clearance(FAR if within is None else within, arm) if arm else FAR
        if within is None or clearance < within:
            simulation.settle()
            return clearance
    few = f", in the others nothing is within {within:g} m of the arm" if within is not None else ""
    raise StartError(
        f"scene {simulation.scene.name!r} with robot {robot!r}: none of {tries} random places is a valid start "
        f"({touching} touch something{few}); make room in the scene, let the robot start in a smaller pose, or ask for less"
    )


def draw_place(simulation: Simulation, rng: np.random.Generator, tries: int = TRIES) -> None:
    """Put the robot somewhere where it touches nothing, and the objects where they settled. Raises StartError where there is no such place.

    Quicker than :func:`draw_start`, and good for pictures; what is played from here may depend, by rounding, on what was tried before.
    """
    if not _draw(simulation, rng, tries)[1]:
        raise StartError(
            f"scene {simulation.scene.name!r}: the robot touches something in each of {tries} random places; make room in the scene"
        )


def _draw(simulation: Simulation, rng: np.random.Generator, tries: int) -> tuple[int, bool]:
    """Draw until the robot touches nothing: how often it was drawn, and whether it was found."""
    areas = simulation.scene.areas
    if not areas:
        raise StartError(
            f"scene {simulation.scene.name!r} has no area in which a robot may start; give it a room, or areas"
        )
    simulation.place(np.array(PARKED), np.zeros(len(simulation.robot.joints)))
    sizes = np.array([(area.x[1] - area.x[0]) * (area.y[1] - area.y[0]) for area in areas])
    for drawn in range(1, tries + 1):
        area = areas[int(rng.choice(len(areas), p=sizes / sizes.sum()))]
        base, joints = (
            np.array([rng.uniform(*area.x), rng.uniform(*area.y), rng.uniform(-math.pi, math.pi)]),
            simulation.robot.draw_joints(rng),
        )
        if simulation.fits(base, np.clip(joints, *simulation.robot.limits.T)):
            return drawn, True
    return tries, False
