"""The navigation rooms in the form that Stable-Baselines3 wants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from stable_baselines3.common.vec_env import VecEnv


class Rooms(VecEnv):
    """A Gymnasium vector environment (``SAME_STEP``) as a Stable-Baselines3 ``VecEnv``.

    Parameters
    ----------
    environment : gymnasium.vector.VectorEnv
    reward_scale : float
        Rewards are multiplied by it; it keeps the value function's targets near 1.
    """

    def __init__(self, environment: VectorEnv, reward_scale: float = 1.0):
        if environment.metadata.get("autoreset_mode") != AutoresetMode.SAME_STEP:
            raise ValueError(
                "Stable-Baselines3 resets an ended episode in the same step: make the environment with AutoresetMode.SAME_STEP"
            )
        self.environment, self.reward_scale = environment, reward_scale
        self.render_mode = None
        super().__init__(
            environment.num_envs,
            environment.single_observation_space,
            environment.single_action_space,
        )

    def seed(self, seed: int | None = None) -> list[int]:
        """Seed the next reset, every room differently; not with neighbouring numbers, so that rooms of different `seed`, >= 0, are never the same."""
        self._seeds = np.random.SeedSequence(seed).generate_state(self.num_envs, np.uint64).tolist()
        return self._seeds

    def reset(self) -> np.ndarray:
        """Reset all rooms; with seeds given by :meth:`seed`, room i gets the i-th."""
        seeds = None if all(s is None for s in self._seeds) else list(self._seeds)
        observations, _ = self.environment.reset(seed=seeds)
        self._reset_seeds()
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        observations, rewards, terminated, truncated, infos = self.environment.step(self._actions)
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        ended = terminated | truncated
        for r in np.flatnonzero(ended):
            told[r] = {
                "terminal_observation": infos["final_obs"][r],
                "TimeLimit.truncated": bool(truncated[r] and not terminated[r]),
            }
        return observations, (rewards * self.reward_scale).astype(np.float32), ended, told

    def close(self) -> None:
        self.environment.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        if attr_name == "render_mode":  # which Stable-Baselines3 asks every environment
            return [None for _ in self._get_indices(indices)]
        owner = (
            self.environment if hasattr(self.environment, attr_name) else self.environment.unwrapped
        )
        value = getattr(owner, attr_name)  # raises AttributeError, as the single environments would
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError(
            "the rooms share one compiled loop; make a new environment instead"
        )

    def env_method(
        self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any
    ) -> list[Any]:
        raise NotImplementedError(
            "the rooms share one compiled loop; there are no single environments to call"
        )

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[np.ndarray | None]:
        return [None] * self.num_envs
