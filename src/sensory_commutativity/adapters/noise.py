"""A world with the noise of a real robot: of its sensors, its actuators, and its reset."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import ArgumentError
from ..scp.world import Dof, Observation, Resting, SequenceLimiter, Snapshot, World, play


class NoisyWorld:
    """Another world, with Gaussian noise of a standard deviation of one's choice.

    It breaks the promise that a replay is the same, on purpose: a restore restores the world
    within, not the noise. :func:`.measure` takes it with ``check=False``, or without a restore,
    with ``protocol="return"``.

    Parameters
    ----------
    world : World
    sensor : float
        Of every number of an observation, in its unit. Integers are rounded, and 8-bit colours
        stay in [0, 255].
    actuator : float
        Of every action, as a share of it; an action of 0 stays 0.
    reset : float
        Of the start after a restore, in actions of 1: every degree of freedom is moved by a random
        number of them.

    Raises
    ------
    ArgumentError
        If a standard deviation is negative or not finite.
    """

    def __init__(
        self, world: World, sensor: float = 0.0, actuator: float = 0.0, reset: float = 0.0
    ):
        for name, value in (("sensor", sensor), ("actuator", actuator), ("reset", reset)):
            if isinstance(value, bool) or not np.isfinite(value) or value < 0:
                raise ArgumentError(f"{name}: expected a number of at least 0, got {value!r}")
        self.world = world
        self.dofs: tuple[Dof, ...] = world.dofs
        self.sensor, self.actuator, self.offset = float(sensor), float(actuator), float(reset)
        self._rng = np.random.default_rng(0)
        if isinstance(world, Resting):
            self.rest: Callable[[int], None] = world.rest
        if isinstance(world, SequenceLimiter):
            self.limit: Callable[[Snapshot, np.ndarray], np.ndarray] = world.limit

    @property
    def name(self) -> str:
        return f"noisy {getattr(self.world, 'name', type(self.world).__name__)}"

    def reset(self, rng: np.random.Generator) -> None:
        """Reset the world; all noise until the next reset is drawn from a generator from `rng`."""
        self.world.reset(rng)
        self._rng = np.random.default_rng(rng.integers(2**63))

    def snapshot(self) -> Any:
        return self.world.snapshot()

    def restore(self, snapshot: Any) -> None:
        """Restore the world, off by the noise of the reset."""
        self.world.restore(snapshot)
        if self.offset:
            offset = self._rng.normal(0.0, self.offset, len(self.dofs))
            steps = max(1, int(np.ceil(np.abs(offset).max())))  # an action is at most 1
            play(self.world, np.tile(offset / steps, (steps, 1)))

    def step(self, action: np.ndarray) -> None:
        self.play(np.asarray(action, np.float64)[None])

    def play(self, actions: np.ndarray) -> None:
        """Play actions, float (steps, n_dofs), each off by the noise of the actuators."""
        if self.actuator:
            actions = actions * (1 + self._rng.normal(0.0, self.actuator, np.shape(actions)))
        play(self.world, actions)

    def observe(self) -> Observation:
        """What the world's sensors say, off by their noise; of the same type."""
        observation = self.world.observe()
        if not self.sensor:
            return observation
        noisy = observation + self._rng.normal(0.0, self.sensor, observation.shape)
        if observation.dtype.kind in "iu":
            limits = np.iinfo(observation.dtype)
            noisy = np.clip(np.rint(noisy), limits.min, limits.max)
        return noisy.astype(observation.dtype)
