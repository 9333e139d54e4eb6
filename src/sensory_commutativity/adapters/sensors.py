"""Which numbers of an observation are compared: all, those of some keys, or those of the world."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np

from ..errors import ArgumentError
from ..scp.sequences import sample_sequence
from ..seeding import generator

if TYPE_CHECKING:
    from .gymnasium import GymnasiumWorld

WORLD = "world"
"""Instead of keys: the sensors that do not move when nothing is touched."""
WORLD_STARTS, WORLD_LENGTH, WORLD_REST = 10, 20, 100
"""Starts, actions of a sequence and most steps of rest with which those are found. Chosen."""
MOVES = 0.01
"""Share of its unit by which a sensor must change to count as moved, and share of the sequences in
which a sensor of the world may move. Chosen."""


def select_sensors(env: gymnasium.Env, sensors: Sequence[str] | None, name: str) -> np.ndarray:
    """Indices of the chosen sensors in the flattened observation.

    Raises
    ------
    ArgumentError
        If the observations have no such key.
    """
    space = env.observation_space
    keys = getattr(space, "spaces", None)
    if sensors is None:
        return np.arange(_size(space))
    if not isinstance(keys, dict):
        raise ArgumentError(
            f"sensors: the observations of {name} have no names; leave it out, or choose "
            f"[{WORLD!r}]"
        )
    for sensor in sensors:
        if sensor not in keys:
            raise ArgumentError(
                f"sensors: {name} has no {sensor!r}; choose from "
                f"{', '.join(map(str, keys))}, or {WORLD} or pixels"
            )
    chosen: list[int] = []
    at = 0
    for key in sorted(keys):
        size = _size(keys[key])
        if key in sensors:
            chosen.extend(range(at, at + size))
        at += size
    return np.array(chosen, int)


def find_world_sensors(world: GymnasiumWorld) -> np.ndarray:
    """Whether each sensor belongs to the world: the agent moves it only by touching something.

    From random starts, random sequences of every action are played. A sensor of the world does not
    move on the way, in all but a share MOVES of the sequences that touch nothing new.

    Parameters
    ----------
    world : GymnasiumWorld
        With its units; all its sensors are chosen.

    Returns
    -------
    bool (size,)

    Raises
    ------
    ArgumentError
        If the simulator does not tell what touches what, if every sequence touches something, or
        if there is no such sensor.
    """
    if not world.knows_contacts:
        raise ArgumentError(
            f"sensors: {WORLD} needs a simulator that tells what touches what (MuJoCo, PyBullet); "
            f"that of {world.name} does not"
        )
    tolerance = np.where(np.isfinite(world.unit), MOVES * world.unit, 0.0)
    moved = []
    n = len(world.dofs)
    for i in range(WORLD_STARTS):
        rng = generator(0, "world sensors", i)
        world.reset(rng)
        start = world.snapshot()
        world.restore(start)
        before = world.observe()
        world.trace(np.zeros((WORLD_LENGTH, n)), WORLD_REST)
        touched = world.happened().touched
        for k in range(n):
            sequence = world.limit(start, sample_sequence(rng, WORLD_LENGTH, k, n))
            world.restore(start)
            visited = world.trace(sequence, WORLD_REST)
            if not world.happened().touched - touched:
                moved.append((np.abs(visited - before) > tolerance).any(axis=0))
    if not moved:
        raise ArgumentError(
            f"sensors: every sequence in {world.name} touches something, so that sensors of the "
            "world cannot be told from those of the body; choose them by name"
        )
    of_world = np.mean(moved, axis=0) <= MOVES
    if not of_world.any():
        raise ArgumentError(
            f"sensors: every sensor of {world.name} also moves when nothing is touched; choose "
            "sensors by name, or leave it out"
        )
    return of_world


def _size(space: Any) -> int:
    """Numbers in a flattened observation, as :func:`.flatten_observation` counts them."""
    parts = getattr(space, "spaces", None)
    if parts is None:
        return int(np.prod(space.shape)) if space.shape is not None else 1
    return sum(map(_size, parts.values() if isinstance(parts, dict) else parts))
