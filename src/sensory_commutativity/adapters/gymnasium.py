"""A Gymnasium environment as a world.

An environment cannot be put back in general. It is therefore reset with the seed of its start and
the actions since then are played again, which is exact for every environment whose ``reset(seed)``
determines everything random.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ArgumentError
from ..scp.world import Dof

if TYPE_CHECKING:
    import gymnasium


@dataclass(frozen=True)
class EpisodeSnapshot:
    """The seed of a reset, and the actions since then: tuple of float arrays (n_dofs,)."""

    seed: int
    actions: tuple[np.ndarray, ...]


class GymnasiumWorld:
    """A :class:`~sensory_commutativity.scp.world.World` made from a Gymnasium environment.

    An action of 0 commands 0 where the range of the action space contains it, otherwise the middle
    of the range; 1 and -1 command its ends. An episode that ends stays at its last observation.

    Parameters
    ----------
    env : gymnasium.Env
        With actions in a Box with finite bounds. Use ``max_episode_steps`` of ``gymnasium.make`` if
        its episodes are shorter than a sequence.
    sensors : sequence of str, optional
        Keys of a Dict observation to use; all by default.

    Raises
    ------
    ArgumentError
        If the actions are not continuous and bounded, or a sensor does not exist.
    """

    def __init__(self, env: gymnasium.Env, sensors: Sequence[str] | None = None):
        from gymnasium import spaces

        space = env.action_space
        spec = getattr(env, "spec", None)
        name = type(env).__name__ if spec is None else spec.id
        if not isinstance(space, spaces.Box):
            raise ArgumentError(
                f"env: {name} has actions in {space}; only continuous actions, a Box, can be "
                "permuted within a degree of freedom"
            )
        if not (np.isfinite(space.low).all() and np.isfinite(space.high).all()):
            raise ArgumentError(
                f"env: {name} has unbounded actions; wrap it in gymnasium.wrappers.RescaleAction "
                "or ClipAction"
            )
        self.env, self.name = env, name
        self._low = space.low.astype(np.float64).ravel()
        self._high = space.high.astype(np.float64).ravel()
        self.dofs = tuple(Dof(f"action-{i}", "1", 1.0) for i in range(len(self._low)))
        self._sensors = _check_sensors(env.observation_space, sensors, name)
        self._seed: int | None = None
        self._actions: list[np.ndarray] = []
        self._observation: np.ndarray
        self._ended = False

    def reset(self, rng: np.random.Generator) -> None:
        """Reset the environment with a seed that is drawn from `rng`."""
        self._restart(int(rng.integers(2**31)))

    def snapshot(self) -> EpisodeSnapshot:
        if self._seed is None:
            raise RuntimeError("the world has no situation yet: call reset(rng) first")
        return EpisodeSnapshot(self._seed, tuple(self._actions))

    def restore(self, snapshot: EpisodeSnapshot) -> None:
        self._restart(snapshot.seed)
        for action in snapshot.actions:
            self.step(action)

    def step(self, action: np.ndarray) -> None:
        action = np.clip(np.asarray(action, np.float64), -1.0, 1.0)
        self._actions.append(action)
        if self._ended:
            return
        observation, _, terminated, truncated, _ = self.env.step(self._command(action))
        if truncated and not terminated:
            raise ArgumentError(
                f"env: {self.name} truncated the episode after {len(self._actions)} steps; make it "
                "with a larger max_episode_steps"
            )
        self._observation = self._flatten(observation)
        self._ended = bool(terminated)

    def observe(self) -> np.ndarray:
        return self._observation.copy()

    def happened(self) -> bool:
        """Return whether the episode has terminated."""
        return self._ended

    def _restart(self, seed: int) -> None:
        observation, _ = self.env.reset(seed=seed)
        self._seed, self._actions, self._ended = seed, [], False
        self._observation = self._flatten(observation)

    def _command(self, action: np.ndarray) -> np.ndarray:
        low, high = self._low, self._high
        through_zero = np.where(action >= 0, action * high, -action * low)
        linear = low + (action + 1) / 2 * (high - low)
        command = np.where((low <= 0) & (high >= 0), through_zero, linear)
        space = self.env.action_space
        return command.reshape(space.shape).astype(space.dtype)

    def _flatten(self, observation: Any) -> np.ndarray:
        from gymnasium import spaces

        space = self.env.observation_space
        if self._sensors is not None:
            parts = [np.asarray(observation[key]).ravel() for key in self._sensors]
            return np.concatenate(parts)
        if isinstance(space, spaces.Box):
            return np.array(observation)
        return np.array(spaces.flatten(space, observation))


def from_gymnasium(env: gymnasium.Env, sensors: Sequence[str] | None = None) -> GymnasiumWorld:
    """Return a Gymnasium environment as a world; see :class:`GymnasiumWorld`."""
    return GymnasiumWorld(env, sensors)


def _check_sensors(space: Any, sensors: Sequence[str] | None, name: str) -> tuple[str, ...] | None:
    keys = getattr(space, "spaces", None)
    if sensors is None:
        return None
    if not isinstance(keys, dict):
        raise ArgumentError(f"sensors: the observations of {name} have no names; leave it out")
    for sensor in sensors:
        if sensor not in keys:
            raise ArgumentError(
                f"sensors: {name} has no {sensor!r}; choose from {', '.join(map(str, keys))}"
            )
    return tuple(sensors)
