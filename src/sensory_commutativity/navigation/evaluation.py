"""Evaluation of a policy by deterministic episodes with given seeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from gymnasium.vector import VectorEnv
from stable_baselines3.common.policies import BasePolicy


class Episodes(NamedTuple):
    """Results of `n` episodes."""

    returns: np.ndarray  # float64 (n,): undiscounted sum of rewards
    lengths: np.ndarray  # int64 (n,): steps
    terminated: np.ndarray  # bool (n,): ended in a zone, not by the time limit

    @property
    def success_rate(self) -> float:
        """Fraction of episodes that ended in the goal."""
        return float((self.terminated & (self.returns > 0)).mean())

    @property
    def dead_rate(self) -> float:
        """Fraction of episodes that ended in a dead zone."""
        return float((self.terminated & (self.returns < 0)).mean())


def evaluate(policy: BasePolicy, environment: VectorEnv, seeds: Sequence[int]) -> Episodes:
    """Play one deterministic episode in each sub-environment.

    Parameters
    ----------
    policy : BasePolicy
        A policy of Stable-Baselines3. A recurrent state is passed from step to step.
    environment : gymnasium.vector.VectorEnv
        With one sub-environment per seed. Only the first episode of each counts.
    seeds : sequence of int
        Seeds of the sub-environments.
    """
    n = environment.num_envs
    # VectorEnv annotates `seed` as an int, but documents and implements lists of seeds.
    observations, _ = environment.reset(seed=list(seeds))  # type: ignore[arg-type]
    state = None
    episode_starts = np.ones(n, bool)
    returns = np.zeros(n)
    lengths = np.zeros(n, np.int64)
    terminated = np.zeros(n, bool)
    running = np.ones(n, bool)
    while running.any():
        actions, state = policy.predict(observations, state, episode_starts, deterministic=True)
        episode_starts = np.zeros(n, bool)
        observations, rewards, terminations, truncations, _ = environment.step(actions)
        returns[running] += rewards[running]
        lengths[running] += 1
        terminated |= running & terminations
        running &= ~(terminations | truncations)
    return Episodes(returns, lengths, terminated)
