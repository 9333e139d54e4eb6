"""Adapter from Gymnasium's vector environments to those of Stable-Baselines3."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from stable_baselines3.common.vec_env import VecEnv


class Sb3VecEnv(VecEnv):
    """A Gymnasium vector environment as a Stable-Baselines3 ``VecEnv``.

    Parameters
    ----------
    environment : gymnasium.vector.VectorEnv
        With ``AutoresetMode.SAME_STEP``.
    reward_scale : float
        Factor of all rewards. It keeps the targets of the value function near 1.

    Raises
    ------
    ValueError
        If the environment has another autoreset mode.
    """

    def __init__(self, environment: VectorEnv, reward_scale: float = 1.0):
        if environment.metadata.get("autoreset_mode") != AutoresetMode.SAME_STEP:
            raise ValueError(
                "Stable-Baselines3 resets an episode in the step that ends it: "
                "create the environment with AutoresetMode.SAME_STEP"
            )
        self.environment = environment
        self.reward_scale = reward_scale
        self.render_mode = None
        super().__init__(
            environment.num_envs,
            environment.single_observation_space,
            environment.single_action_space,
        )

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Set the seeds of the next reset, a different one for each sub-environment.

        Stable-Baselines3 itself uses seed, seed + 1, ... Here they are hashed, so that adapters
        with different `seed`, >= 0, never share a sub-environment's seed.
        """
        self._seeds = np.random.SeedSequence(seed).generate_state(self.num_envs, np.uint64).tolist()
        return self._seeds

    def reset(self) -> np.ndarray:
        """Reset all sub-environments, with the seeds from :meth:`seed` if it was called since."""
        seeds = None if all(s is None for s in self._seeds) else list(self._seeds)
        # VectorEnv annotates `seed` as an int, but documents and implements lists of seeds.
        observations, _ = self.environment.reset(seed=seeds)  # type: ignore[arg-type]
        self._reset_seeds()
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        observations, rewards, terminated, truncated, infos = self.environment.step(self._actions)
        sb3_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        dones = terminated | truncated
        for i in np.flatnonzero(dones):
            sb3_infos[i] = {
                "terminal_observation": infos["final_obs"][i],
                "TimeLimit.truncated": bool(truncated[i] and not terminated[i]),
            }
        return observations, (rewards * self.reward_scale).astype(np.float32), dones, sb3_infos

    def close(self) -> None:
        self.environment.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        if attr_name == "render_mode":  # the base class asks for it before the environment is set
            return [None for _ in self._get_indices(indices)]
        wrapper = self.environment
        owner = wrapper if hasattr(wrapper, attr_name) else wrapper.unwrapped
        value = getattr(owner, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError("sub-environments share their attributes")

    def env_method(
        self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any
    ) -> list[Any]:
        raise NotImplementedError("there are no single sub-environments whose methods to call")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[np.ndarray | None]:
        return [None] * self.num_envs
