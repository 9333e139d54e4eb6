"""Ground truth for the local SCP: what the arm meets when a joint sweeps its usual range.

How far a random sequence drives a joint varies. The joint is swept over the median excursion of
SC-experiments in free space, from the start of every experiment at a pose, and the median of the
clearances is reported: half of the experiments come as near to something.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...scp.sequences import sample_sequence
from ...worlds.apartment.physics.simulation import Simulation
from ...worlds.apartment.physics.starts import arm_links
from ...worlds.apartment.scenes.scene import Fixture

MAX_CLEARANCE = 1.0
"""Metres up to which clearances are measured."""
SWEEP_STEPS = 9
"""Positions of the swept joint at which clearances are measured. Chosen: no point of an arm of one
metre is then further than 10 cm from a measured position."""
SEQUENCES = 2_000
"""Random sequences from which the median excursion is estimated. Chosen."""
POINTS_PER_LINK = 4
"""Points along each link that are tested for furniture below. Chosen."""


class Reach(NamedTuple):
    """What an arm meets when it sweeps.

    Attributes
    ----------
    clearance : float
        Metres to the nearest fixture, at most MAX_CLEARANCE; negative if the arm enters it.
    nearest : str
        Name of that fixture; empty if there is none within MAX_CLEARANCE.
    over_low : bool
        Whether the arm passes over low furniture.
    """

    clearance: float
    nearest: str
    over_low: bool


def median_excursion(length: int, speed: float, rng: np.random.Generator) -> tuple[float, float]:
    """Estimate how far half of all SC-experiments drive a joint in free space.

    Parameters
    ----------
    length : int
        Number of actions in a sequence.
    speed : float
        What an action of 1 moves.
    rng : numpy.random.Generator

    Returns
    -------
    low, high : float
        Median lowest and median highest position over both orders, relative to the start, in the
        unit of `speed`.
    """
    extremes = np.empty((SEQUENCES, 2))
    for i in range(SEQUENCES):
        sequence = sample_sequence(rng, length, 0, 1)[:, 0]
        permuted = rng.permutation(sequence)
        positions = np.concatenate([[0.0], np.cumsum(sequence), np.cumsum(permuted)]) * speed
        extremes[i] = positions.min(), positions.max()
    low, high = np.median(extremes, axis=0)
    return float(low), float(high)


def measure_median_reach(
    simulation: Simulation,
    base: np.ndarray,
    joint: int,
    excursion: tuple[float, float],
    low_furniture: Collection[str],
    starts: np.ndarray,
) -> Reach:
    """Sweep the arm from several starts; return the sweep with the (lower) median clearance.

    Parameters are those of :func:`measure_reach`, but for `starts`: float64 (n, joints).
    `over_low` holds if it does for most of the sweeps.
    """
    sweeps = sorted(
        (
            measure_reach(simulation, base, joint, excursion, low_furniture, start)
            for start in starts
        ),
        key=lambda reach: reach.clearance,
    )
    median = sweeps[(len(sweeps) - 1) // 2]
    return median._replace(over_low=2 * sum(reach.over_low for reach in sweeps) > len(sweeps))


def measure_reach(
    simulation: Simulation,
    base: np.ndarray,
    joint: int,
    excursion: tuple[float, float],
    low_furniture: Collection[str],
    start: np.ndarray,
) -> Reach:
    """Sweep one joint while all others stay, and measure what the arm meets.

    Parameters
    ----------
    simulation : Simulation
        Its robot is moved; its objects are not.
    base : float64 (3,)
        x, y (metres) and heading (rad).
    joint : int
        Index into :attr:`.robot.Robot.joints` of the joint that sweeps.
    excursion : tuple of float
        Range of the sweep relative to `start`, rad; clipped to the joint's limits.
    low_furniture : collection of str
        Names of low fixtures.
    start : float64 (joints,)
        Joint positions, rad or m.
    """
    robot, fixtures = simulation.robot, simulation.scene.fixtures
    boxes = [_bounding_box(fixture) for fixture in fixtures if fixture.name in low_furniture]
    links = arm_links(simulation)
    nearest, name, over_low = MAX_CLEARANCE, "", False
    for angle in np.linspace(*excursion, SWEEP_STEPS):
        joints = start.copy()
        joints[joint] = np.clip(start[joint] + angle, *robot.limits[joint])
        simulation.place_robot(base, joints)
        distance, index = simulation.collisions.nearest_fixture(MAX_CLEARANCE, links)
        if index is not None and distance < nearest:
            nearest, name = distance, fixtures[index].name
        origins = simulation.body.link_poses(base, joints)[list(links), :3, 3]  # (links, 3)
        points = _points_along(origins)
        over_low |= any(_passes_over(points, low, high) for low, high in boxes)
    return Reach(nearest, name, bool(over_low))


def _points_along(origins: np.ndarray) -> np.ndarray:
    """Points on the lines between successive link origins, (links, 3): float64 (n, 3)."""
    fractions = np.linspace(0, 1, POINTS_PER_LINK)[:, None]
    lines = [a + (b - a) * fractions for a, b in pairwise(origins)]
    return np.concatenate(lines or [origins])


def _passes_over(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether all points are above a box, and at least one of them right above it."""
    right_above = ((points > low) & (points < high))[:, :2].all(1)
    return bool(right_above.any() and points[:, 2].min() > high[2])


def _bounding_box(fixture: Fixture) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest x, y and z of a fixture: float64 (3,) each, metres."""
    vertices = np.concatenate([part.mesh.vertices for part in fixture.parts])
    return vertices.min(0), vertices.max(0)
