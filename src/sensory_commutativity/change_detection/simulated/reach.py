"""What is truly within an arm's reach: the arm swept as far as a random sequence drives it, and what it meets (for comparison with the local SCP).

How far an arm gets differs from experiment to experiment. Taken is what half of all experiments reach, on either side, in one of their two orders,
from where each of the experiments at a place began; and of these what half of them meet.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...scp.sequences import sample_sequence
from ...worlds.apartment.physics.simulation import Simulation
from ...worlds.apartment.physics.starts import arm_links

MOST = 1.0
"""Metres: clearances are measured up to here."""
STOPS = 9
"""Positions of the swept joint; chosen: an arm of a metre is then never further than 10 cm from where it was looked at."""
SEQUENCES = 2_000
"""Random sequences from which the median excursion is found."""
ALONG = 4
"""Points between neighbouring links at which it is looked what lies below the arm."""


class Reach(NamedTuple):
    """What a swept arm meets.

    Attributes
    ----------
    clearance : float
        Metres to the nearest fixture, at most MOST; below 0 if the arm is inside it.
    nearest : str
        Its name; empty if there is none within MOST.
    over_low : bool
        Whether the arm passes over one of the low things.
    """

    clearance: float
    nearest: str
    over_low: bool


def usual_excursion(length: int, speed: float, rng: np.random.Generator) -> tuple[float, float]:
    """How far down and how far up, from where it began, half of all SC-experiments drive a joint, in the unit of `speed`, if nothing is in the way.

    Parameters
    ----------
    length : int
        Actions of a sequence.
    speed : float
        What an action of 1 moves.
    """
    ends = np.empty((SEQUENCES, 2))
    for i in range(SEQUENCES):
        sequence = sample_sequence(rng, length, 0, 1)[:, 0]
        both = (
            np.concatenate([[0.0], np.cumsum(sequence), np.cumsum(rng.permutation(sequence))])
            * speed
        )
        ends[i] = both.min(), both.max()
    low, high = np.median(ends, axis=0)
    return float(low), float(high)


def usual_reach(
    simulation: Simulation,
    base: np.ndarray,
    joint: int,
    excursion: tuple[float, float],
    low: Collection[str],
    starts: np.ndarray,
) -> Reach:
    """The sweep with the (lower) median clearance of those from all `starts`, positions of the joints float64 (n, joints), rad and metres.

    Half of the sweeps come as near to something; the arm passes over low things if most do. The other parameters: :func:`swept_reach`.
    """
    found = sorted(
        (swept_reach(simulation, base, joint, excursion, low, joints) for joints in starts),
        key=lambda reach: reach.clearance,
    )
    middle = found[(len(found) - 1) // 2]
    return middle._replace(over_low=2 * sum(reach.over_low for reach in found) > len(found))


def swept_reach(
    simulation: Simulation,
    base: np.ndarray,
    joint: int,
    excursion: tuple[float, float],
    low: Collection[str],
    start: np.ndarray,
) -> Reach:
    """What the arm meets when a joint sweeps and all others stay.

    Parameters
    ----------
    simulation : Simulation
        The robot is put elsewhere; objects stay.
    base : float64 (3,)
        x, y (metres) and heading (rad).
    joint : int
        Which of :attr:`.robot.Robot.joints` sweeps.
    excursion : tuple of float
        How far down and up, rad; its limits stop it.
    low : collection of str
        Names of low furniture.
    start : float64 (joints,)
        Where all joints begin.
    """
    robot, fixtures = simulation.robot, simulation.scene.fixtures
    boxes = [_bounds(fixture) for fixture in fixtures if fixture.name in low]
    links, nearest, name, over = arm_links(simulation), MOST, "", False
    for angle in np.linspace(*excursion, STOPS):
        joints = start.copy()
        joints[joint] = np.clip(start[joint] + angle, *robot.limits[joint])
        simulation.put_robot(base, joints)
        distance, index = simulation.nearest_fixture(MOST, links)
        if index is not None and distance < nearest:
            nearest, name = distance, fixtures[index].name
        arm = simulation.body.link_poses(base, joints)[list(links), :3, 3]
        points = np.concatenate(
            [a + (b - a) * np.linspace(0, 1, ALONG)[:, None] for a, b in pairwise(arm)] or [arm]
        )
        over |= any(
            ((points > bottom) & (points < [*top[:2], np.inf]))[:, :2].all(1).any()
            and points[:, 2].min() > top[2]
            for bottom, top in boxes
        )
    return Reach(nearest, name, bool(over))


def _bounds(fixture) -> tuple[np.ndarray, np.ndarray]:
    vertices = np.concatenate([part.mesh.vertices for part in fixture.parts])
    return vertices.min(0), vertices.max(0)
