"""PyBullet's worlds and their saved states, closed and forgotten with the last one who uses them."""

from __future__ import annotations

import weakref

import pybullet


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
