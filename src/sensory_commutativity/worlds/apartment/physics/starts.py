"""Random valid start poses, and the clearance of the arm there (paper, section III-B)."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from ....errors import UserError
from .simulation import PARKED, Simulation

MAX_CLEARANCE = 1.0
"""Metres: larger clearances are not measured."""
MAX_DRAWS = 5_000
"""Poses that are drawn before a start counts as impossible; chosen: takes about 20 s, and is a
hundred times what the stand-in apartments need."""

EXPLAINED_DRAWS, EXPLAINED_PAIRS = 50, 4
"""Poses that are drawn to say why none is valid, and pairs that are named. Chosen."""


class StartError(UserError):
    """There is no valid start pose."""


def arm_links(simulation: Simulation) -> tuple[int, ...]:
    """Return the links of the arm: those moved by joints that turn.

    This excludes the base and a lift. Links are numbered as in :class:`.body.Body`.
    """
    joints = simulation.robot.joints
    return tuple(i for i, joint in enumerate(joints, start=1) if joint.kind != "prismatic")


def draw_start(
    simulation: Simulation,
    rng: np.random.Generator,
    within: float | None = None,
    max_draws: int | None = None,
) -> float:
    """Place the robot, at rest, in a random valid pose.

    The position is uniform over the scene's areas and the heading over all directions; joints are
    drawn from the robot's start ranges. If the robot touches anything, or itself, the whole pose
    is drawn again, so all valid poses are equally likely.

    Parameters
    ----------
    simulation : Simulation
    rng : numpy.random.Generator
    within : float, optional
        Metres: something must be nearer to the arm than this.
    max_draws : int, optional
        Maximum number of draws; MAX_DRAWS if not given.

    Returns
    -------
    float
        Metres from the arm to the nearest fixture or object; at most MAX_CLEARANCE.

    Raises
    ------
    StartError
        No draw was valid.
    """
    arm, robot = arm_links(simulation), simulation.robot.description.name
    if within is not None and not arm:
        raise StartError(
            f"robot {robot!r} has no joint that turns, so nothing is within its reach; "
            "let it start anywhere"
        )
    max_draws = max_draws or MAX_DRAWS
    remaining, touching = max_draws, 0
    while remaining > 0:
        draws, success = _draw_free(simulation, rng, remaining)
        remaining -= draws
        touching += draws - success
        if not success:
            break
        # Reset, so that earlier draws make no difference.
        simulation.reset(simulation.base(), simulation.joints())
        clearance = MAX_CLEARANCE
        if arm:
            max_distance = MAX_CLEARANCE if within is None else within
            clearance = simulation.collisions.clearance(max_distance, arm)
        if within is None or clearance < within:
            simulation.settle()
            return clearance
    far = f", in the others nothing is within {within:g} m of the arm" if within is not None else ""
    why, remedy = explain_contacts(simulation, rng)
    raise StartError(
        f"scene {simulation.scene.name!r} with robot {robot!r}: none of {max_draws} random poses "
        f"is a valid start ({touching} touch something{why}{far}); {remedy}"
    )


def draw_free_pose(
    simulation: Simulation, rng: np.random.Generator, max_draws: int = MAX_DRAWS
) -> None:
    """Place the robot where it touches nothing, and reset the objects.

    Faster than :func:`draw_start`, and sufficient for images; but a motion from here may depend,
    by rounding, on the poses that were drawn before.

    Raises
    ------
    StartError
        No draw was valid.
    """
    if not _draw_free(simulation, rng, max_draws)[1]:
        why, remedy = explain_contacts(simulation, rng)
        raise StartError(
            f"scene {simulation.scene.name!r}: the robot touches something in each of {max_draws} "
            f"random poses{why}; {remedy}"
        )


def explain_contacts(simulation: Simulation, rng: np.random.Generator) -> tuple[str, str]:
    """Say which links touch what in random poses, most often first, and what helps."""
    counts: Counter[tuple[str, str, str]] = Counter()
    for _ in range(EXPLAINED_DRAWS):
        if not simulation.fits(*_draw_pose(simulation, rng)):
            counts.update(simulation.collisions.penetrating_pairs())
    shown = [
        f"{_describe_pair(simulation, pair)} in {count / EXPLAINED_DRAWS:.0%}"
        for pair, count in counts.most_common(EXPLAINED_PAIRS)
    ]
    more = f" and {len(counts) - len(shown)} more pairs" if len(counts) > len(shown) else ""
    why = f": {', '.join(shown)}{more}" if shown else ""
    kind = counts.most_common(1)[0][0][1] if counts else ""
    if kind == "link":
        return why, (
            "list pairs of links that touch in every pose under the key passing of the robot's "
            "file (sencom robot init finds them), or let it start in another pose"
        )
    if kind == "floor":
        return why, "raise the robot with the key height, or let it start in another pose"
    return why, ("make room in the scene, let the robot start in a smaller pose, or ask for less")


def _describe_pair(simulation: Simulation, pair: tuple[str, str, str]) -> str:
    link, kind, name = pair
    scene = simulation.scene
    if kind == "link":
        return f"its own links {link!r} and {name!r}"
    if kind == "fixture":
        return f"{link!r} and the fixture {scene.fixtures[int(name)].name!r}"
    if kind == "object":
        return f"{link!r} and the object {scene.movables[int(name)].name!r}"
    return f"{link!r} and the floor"


def _draw_free(
    simulation: Simulation, rng: np.random.Generator, max_draws: int
) -> tuple[int, bool]:
    """Draw poses until the robot touches nothing; return the number of draws, and the success."""
    areas = simulation.scene.areas
    if not areas:
        raise StartError(
            f"scene {simulation.scene.name!r} has no area in which a robot may start; "
            "give it a room, or areas"
        )
    simulation.reset(np.array(PARKED), np.zeros(len(simulation.robot.joints)))
    for draw in range(1, max_draws + 1):
        if simulation.fits(*_draw_pose(simulation, rng)):
            return draw, True
    return max_draws, False


def _draw_pose(simulation: Simulation, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Draw a base pose, float64 (3,), and joint positions, float64 (n,)."""
    areas, shares = simulation.scene.areas, simulation.scene.area_shares
    area = areas[int(rng.choice(len(areas), p=shares))]
    base = np.array([rng.uniform(*area.x), rng.uniform(*area.y), rng.uniform(-math.pi, math.pi)])
    joints = simulation.robot.draw_joints(rng)
    return base, simulation.robot.clip_joints(joints)
