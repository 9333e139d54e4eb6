"""What is truly within an arm's reach: the arm swept as far as a random sequence drives it, and what it meets (for comparison with the local SCP).

How far an arm gets differs from experiment to experiment. Taken is what half of all experiments reach, on either side, in one of their two orders.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..sequences import sample_sequence
from ..worlds.apartment.simulation import Simulation
from ..worlds.apartment.starts import arm_links

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


def usual_range(length: int, speed: float, start: tuple[float, float], rng: np.random.Generator) -> tuple[float, float]:
    """Lowest and highest position of a joint that half of all SC-experiments reach, in the unit of `speed`, if nothing is in the way.

    Parameters
    ----------
    length : int
        Actions of a sequence.
    speed : float
        What an action of 1 moves.
    start : tuple of float
        Range from which start positions are drawn.
    """
    ends = np.empty((SEQUENCES, 2))
    for i in range(SEQUENCES):
        sequence = sample_sequence(rng, length, 0, 1)[:, 0]
        both = np.concatenate([[0.0], np.cumsum(sequence), np.cumsum(rng.permutation(sequence))]) * speed + rng.uniform(*start)
        ends[i] = both.min(), both.max()
    low, high = np.median(ends, axis=0)
    return float(low), float(high)


def swept_reach(simulation: Simulation, base: np.ndarray, joint: int, between: tuple[float, float], low: Collection[str]) -> Reach:
    """What the arm meets when a joint sweeps, all others in the middle of their start ranges.

    Parameters
    ----------
    simulation : Simulation
        The robot is put elsewhere; objects stay.
    base : float64 (3,)
        x, y (metres) and heading (rad).
    joint : int
        Which of :attr:`.robot.Robot.joints` sweeps.
    between : tuple of float
        From where to where, rad; its limits stop it.
    low : collection of str
        Names of low furniture.
    """
    robot, fixtures = simulation.robot, simulation.scene.fixtures
    middle = robot.start_ranges.mean(1)
    boxes = [_bounds(fixture) for fixture in fixtures if fixture.name in low]
    links, nearest, name, over = arm_links(simulation), MOST, "", False
    for angle in np.linspace(*between, STOPS):
        joints = middle.copy()
        joints[joint] = np.clip(angle, *robot.limits[joint])
        simulation.put_robot(base, joints)
        distance, index = simulation.nearest_fixture(MOST, links)
        if index is not None and distance < nearest:
            nearest, name = distance, fixtures[index].name
        arm = simulation.body.link_poses(base, joints)[list(links), :3, 3]
        points = np.concatenate([a + (b - a) * np.linspace(0, 1, ALONG)[:, None] for a, b in pairwise(arm)] or [arm])
        over |= any(((points > bottom) & (points < [*top[:2], np.inf]))[:, :2].all(1).any() and points[:, 2].min() > top[2] for bottom, top in boxes)
    return Reach(nearest, name, bool(over))


def _bounds(fixture) -> tuple[np.ndarray, np.ndarray]:
    vertices = np.concatenate([part.mesh.vertices for part in fixture.parts])
    return vertices.min(0), vertices.max(0)
