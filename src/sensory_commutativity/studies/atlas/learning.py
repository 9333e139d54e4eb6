"""PPO with the planar arm, in an action space that its SCPs make.

The protocol was fixed before the run: PPO of Stable-Baselines3 with its default settings, but four
environments and rollouts of 512 steps; the policy that is evaluated takes its mean action. It was
tried once before, with the full action space and the seed DEVELOPMENT_SEED: PPO improved until some
40,000 steps.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from ...seeding import generator, seed_for
from .config import LearningConfig

ENVIRONMENTS, ROLLOUT = 4, 512
"""Environments of a run, and steps of each between updates. Chosen."""
BATCH = 256
"""Samples in a gradient step. Chosen: four times the default, for speed."""
DEVELOPMENT_SEED = 1000
"""With which the protocol was tried; no run that is reported has it."""


def train_curve(
    settings: LearningConfig, action_space: str, seed: int, scp: Mapping[str, float], root: int
) -> pd.DataFrame:
    """Train once; returns a row per evaluation: step, episode_return, displacement.

    Parameters
    ----------
    settings : LearningConfig
    action_space : str
    seed : int
        Of the run.
    scp : mapping of str to float
        Degree of freedom -> SCP.
    root : int
        Root seed of the configuration.
    """
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import DummyVecEnv

    from ...navigation.action_spaces import ScaledAction, action_scales
    from ...worlds.planar_arm import MAX_EPISODE_STEPS, PlanarArmEnv

    rng = generator(root, "learning action space", action_space, seed)
    scales = list(action_scales(action_space, dict(scp), rng).values())

    def make() -> ScaledAction:
        from gymnasium.wrappers import TimeLimit

        return ScaledAction(TimeLimit(PlanarArmEnv(), MAX_EPISODE_STEPS), scales)

    torch.set_num_threads(1)
    run_seed = seed_for(root, "learning run", seed) % 2**31
    model = PPO(
        "MlpPolicy", DummyVecEnv([make] * ENVIRONMENTS), seed=run_seed, n_steps=ROLLOUT,
        batch_size=BATCH, device="cpu",
    )  # fmt: skip
    rows = [(0, *evaluate(model, make(), settings.evaluation_episodes, root))]
    for i in range(1, settings.evaluations + 1):
        step = round(settings.steps * i / settings.evaluations)
        model.learn(step - model.num_timesteps, reset_num_timesteps=False)
        rows.append((step, *evaluate(model, make(), settings.evaluation_episodes, root)))
    return pd.DataFrame(rows, columns=["step", "episode_return", "displacement"])


def evaluate(model: Any, env: Any, episodes: int, root: int) -> tuple[float, float]:
    """Mean return, and mean distance in metres that the puck was pushed, of the same episodes for
    every policy."""
    returns, displacements = [], []
    for i in range(episodes):
        reset_seed = seed_for(root, "learning evaluation", i) % 2**31
        observation, info = env.reset(seed=reset_seed)
        total, ended = 0.0, False
        while not ended:
            action, _ = model.predict(observation, deterministic=True)
            observation, reward, _, ended, info = env.step(action)
            total += reward
        returns.append(total)
        displacements.append(info["displacement"])
    return float(np.mean(returns)), float(np.mean(displacements))
