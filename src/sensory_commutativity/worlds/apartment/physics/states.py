"""PyBullet's worlds and their saved states, closed and forgotten with the last one who uses them; and what else a moment of a simulation is."""

from __future__ import annotations

import weakref
from dataclasses import dataclass

import numpy as np
import pybullet

from ..robots.control import Control


class BulletWorld:
    """A PyBullet world that is closed with the last one who uses it."""

    def __init__(self) -> None:
        self.client = pybullet.connect(pybullet.DIRECT)
        self.close = weakref.finalize(self, pybullet.disconnect, self.client)


class State:
    """A saved state of a PyBullet world, forgotten there with the last one who holds it."""

    def __init__(self, world: BulletWorld):
        self.world = world
        self.number = pybullet.saveState(physicsClientId=world.client)

    def __del__(self) -> None:
        if self.world.close.alive:
            pybullet.removeState(self.number, physicsClientId=self.world.client)


@dataclass(frozen=True)
class Situation:
    """Everything about a simulation at one moment. Only the simulation that it was taken from can be put back into it."""

    state: State
    control: Control
    place: (
        np.ndarray
    )  # float64 (3,): where the robot was put, which is where it is if it has no drive
    origins: np.ndarray  # float64 (movables, 3): where the objects are
    asleep: tuple[bool, ...]  # which of them Bullet lets rest
