"""Snapshots of a simulation, restored so that a replay is exact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..bullet import pybullet
from ..robots.control import ControllerState
from .bullet import BulletWorld, SavedState
from .objects import MovableObjects
from .simulated_robot import SimulatedRobot

_APART = 50.0
"""Metres between bodies that must not touch; chosen: larger than every scene."""


@dataclass(frozen=True)
class SimulationSnapshot:
    """Everything that a simulation's future depends on. Only that simulation can restore it.

    Attributes
    ----------
    state : SavedState
        PyBullet's own state.
    controller : ControllerState
    placed_at : float64 (3,)
        Base pose where the robot was placed.
    object_positions : float64 (objects, 3)
        Metres.
    asleep : tuple of bool
        Which objects Bullet has put to sleep.
    """

    state: SavedState
    controller: ControllerState
    placed_at: np.ndarray
    object_positions: np.ndarray
    asleep: tuple[bool, ...]


def take_snapshot(
    world: BulletWorld, robot: SimulatedRobot, objects: MovableObjects
) -> SimulationSnapshot:
    """Return a snapshot of the current moment."""
    return SimulationSnapshot(
        SavedState(world),
        robot.controller.copy(),
        robot.placed_at.copy(),
        objects.positions(),
        objects.asleep(),
    )


def restore_snapshot(
    snapshot: SimulationSnapshot,
    world: BulletWorld,
    robot: SimulatedRobot,
    objects: MovableObjects,
) -> None:
    """Return to a snapshot, independently of everything since.

    PyBullet restores neither which objects sleep nor, reliably, contacts: its contact cache
    depends on the past. So everything that moves is first moved so far apart that nothing touches,
    which empties the cache. Then the state is restored, with all objects awake, and simulated for
    one step, which detects the contacts. Finally the state is restored once more and the objects
    that slept are put to sleep.

    Raises
    ------
    ValueError
        The snapshot is of another simulation.
    """
    if snapshot.state.world is not world:
        raise ValueError("the snapshot is of another simulation")
    objects.separate(_APART)
    robot.move_away(_APART)
    pybullet.performCollisionDetection(physicsClientId=world.client)
    snapshot.state.restore()
    pybullet.stepSimulation(physicsClientId=world.client)
    snapshot.state.restore()
    objects.set_asleep(snapshot.asleep)
    robot.controller.assign(snapshot.controller)
    robot.placed_at = snapshot.placed_at.copy()
