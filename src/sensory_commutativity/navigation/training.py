"""One training run: an action space and a seed, from the first step to the last evaluation.

A run is a chain of segments, each from one evaluation to the next. A segment starts with new rooms and newly seeded random numbers, so that the
weights, the optimiser's state and the curve so far are all that a killed run needs to go on exactly as if it had not been killed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pandas as pd
import torch
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from stable_baselines3.common.utils import set_random_seed

from ..progress import progress
from ..seeding import seed_for
from ..storage.checkpoints import Checkpoint, CheckpointError
from ..studies.config import Config
from ..studies.navigation.builders import evaluation_seeds, navigation_rooms
from .evaluation import evaluate
from .learner import RoomPPO, make_learner, make_policy
from .rooms import Rooms


def learner_of_run(
    config: Config, action_space: str, seed: int, scales: dict[str, float]
) -> RoomPPO:
    """The learner of a run before its first step."""
    settings = config.navigation.learner
    rooms = navigation_rooms(config, settings.rooms, scales)
    return make_learner(
        Rooms(rooms, settings.reward_scale),
        settings,
        seed_for(config.seed, "navigation", action_space, seed) % 2**32,
    )


def settings_of_run(config: Config, scales: Mapping[str, float]) -> str:
    """All settings that a run depends on apart from its action space's name and its seed, as JSON."""
    flatland, navigation = config.flatland, config.navigation
    refine_masks = {
        "seeds",
        "action_spaces",
        "calibration_splits",
        "threshold_return",
        "solved_success_rate",
        "primary_measure",
        "alpha",
    }
    parts = dict(
        world=flatland.worlds[navigation.world],
        agent=flatland.agents[navigation.agent],
        navigation=navigation,
    )
    return json.dumps(
        dict(
            seed=config.seed,
            scales=scales,
            **{k: part.model_dump(mode="json", exclude=refine_masks) for k, part in parts.items()},
        )
    )


def policy_of_run(config: Config, model: dict[str, Any], where: str) -> RecurrentActorCriticPolicy:
    """The trained policy that a run left as `model` in the file `where`. Raises CheckpointError when it was trained with other settings."""
    if not isinstance(model, dict) or not {"settings", "scales", "policy"} <= set(model):
        raise CheckpointError(f"{where}: no trained policy; run the workflow")
    if model["settings"] != settings_of_run(config, model["scales"]):
        raise CheckpointError(
            f"{where}: a policy that was trained with other settings; run the workflow, or give the configuration of that run"
        )
    environment = navigation_rooms(config, 1, model["scales"])
    policy = make_policy(
        environment.single_observation_space,
        environment.single_action_space,
        config.navigation.learner,
    )
    policy.load_state_dict(model["policy"])
    return policy


def train(
    config: Config, action_space: str, seed: int, scales: dict[str, float], checkpoint: Checkpoint
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Train and evaluate to the end, or go on from the checkpoint.

    Parameters
    ----------
    action_space, seed : str, int
        Which run.
    scales : mapping
        Degree of freedom -> scale in [0, 1], in the order of the actions.
    checkpoint : Checkpoint
        Saved after every segment.

    Returns
    -------
    curve : DataFrame
        A row per evaluation: step, episode_return, success_rate, dead_rate, episode_length, episodes.
    model : dict
        action_space, seed, settings, scales, and policy: the weights.
    """
    torch.set_num_threads(1)
    navigation = config.navigation
    length = navigation.steps // navigation.checkpoints
    seeds = evaluation_seeds(config)
    arena = navigation_rooms(config, len(seeds), scales)
    learner = learner_of_run(config, action_space, seed, scales)
    curve: list[dict[str, float]] = []
    saved = checkpoint.load()
    if saved is not None:
        learner.policy.load_state_dict(saved["policy"])
        learner.policy.optimizer.load_state_dict(saved["optimizer"])
        curve = saved["curve"]
    for segment in progress(
        range(len(curve), navigation.checkpoints), f"{action_space} {seed}", "segment"
    ):
        start = seed_for(config.seed, "navigation", action_space, seed, segment)
        set_random_seed(start % 2**32)
        learner.env.seed(start)
        learner.learn(length)
        episodes = evaluate(learner.policy, arena, seeds)
        curve.append(
            dict(
                step=(segment + 1) * length,
                episode_return=float(episodes.returns.mean()),
                success_rate=episodes.success_rate,
                dead_rate=episodes.dead_rate,
                episode_length=float(episodes.lengths.mean()),
                episodes=len(seeds),
            )
        )
        checkpoint.save(
            dict(
                policy=learner.policy.state_dict(),
                optimizer=learner.policy.optimizer.state_dict(),
                curve=curve,
            )
        )
    model = dict(
        action_space=action_space,
        seed=seed,
        settings=settings_of_run(config, scales),
        scales=dict(scales),
    )
    return pd.DataFrame(curve), dict(**model, policy=learner.policy.state_dict())
