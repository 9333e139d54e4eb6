"""How well does a policy do? Deterministic episodes with seeds of their own, the same for every action space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from gymnasium.vector import VectorEnv
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy


class Episodes(NamedTuple):
    """What came of `n` episodes."""

    returns: np.ndarray  # float64 (n,): sum of rewards, not discounted
    lengths: np.ndarray  # int64 (n,), steps
    terminated: np.ndarray  # bool (n,): ended in a zone, not by time

    @property
    def success_rate(self) -> float:
        """Fraction that ended in the goal."""
        return float((self.terminated & (self.returns > 0)).mean())

    @property
    def dead_rate(self) -> float:
        """Fraction that ended in a dead zone."""
        return float((self.terminated & (self.returns < 0)).mean())


def evaluate(
    policy: RecurrentActorCriticPolicy, environment: VectorEnv, seeds: Sequence[int]
) -> Episodes:
    """Play one episode in each room of `environment`, with the mean of the policy's action; the LSTM's state goes from step to step.

    Parameters
    ----------
    policy : RecurrentActorCriticPolicy
    environment : gymnasium.vector.VectorEnv
        One room per seed; later episodes of a room whose first has ended are ignored.
    seeds : int (n,)
        Of the rooms.
    """
    n = environment.num_envs
    observations, _ = environment.reset(seed=list(seeds))
    state, start = None, np.ones(n, bool)
    returns, lengths, terminated = np.zeros(n), np.zeros(n, np.int64), np.zeros(n, bool)
    running = np.ones(n, bool)
    while running.any():
        actions, state = policy.predict(observations, state, start, deterministic=True)
        start = np.zeros(n, bool)
        observations, rewards, ended, out_of_time, _ = environment.step(actions)
        returns[running] += rewards[running]
        lengths[running] += 1
        terminated |= running & ended
        running &= ~(ended | out_of_time)
    return Episodes(returns, lengths, terminated)
