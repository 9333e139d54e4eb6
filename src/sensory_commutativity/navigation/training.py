"""Training runs that resume after a kill and repeat bit for bit.

A run is a chain of segments, each from one evaluation to the next. A segment starts with new rooms
and newly seeded random numbers. The weights, the state of the optimizer and the learning curve are
therefore all that a killed run needs to continue exactly as if it had not been killed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd
import torch
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from stable_baselines3.common.utils import set_random_seed

from ..progress import progress
from ..seeding import seed_for
from ..storage.checkpoints import Checkpoint, CheckpointError
from .action_spaces import VectorScaledAction
from .evaluation import Episodes, evaluate
from .learner import make_learner, make_policy
from .recurrent import WholeRolloutPPO
from .sb3 import Sb3VecEnv
from .settings import LearnerSettings, TrainingRun
from .task import NavigationTask


def make_scaled_rooms(
    task: NavigationTask, n: int, scales: Mapping[str, float]
) -> VectorScaledAction:
    """Create `n` rooms of a task, with the action space that `scales` define.

    Ended episodes are reset in the same step.
    """
    return VectorScaledAction(task.make_vector_env(n), list(scales.values()))


def learner_of_run(run: TrainingRun) -> WholeRolloutPPO:
    """Create the learner of a run, before its first step."""
    rooms = make_scaled_rooms(run.task, run.learner.rooms, run.scales)
    return make_learner(
        Sb3VecEnv(rooms, run.learner.reward_scale),
        run.learner,
        seed_for(run.root_seed, "navigation", run.action_space, run.seed) % 2**32,
    )


def check_model(model: Any, where: str) -> None:
    """Raise CheckpointError if `model`, read from the file `where`, holds no trained policy."""
    if not isinstance(model, dict) or not {"settings", "scales", "policy"} <= set(model):
        raise CheckpointError(f"{where}: no trained policy; run the workflow")


def policy_of_run(
    model: dict[str, Any], task: NavigationTask, learner: LearnerSettings, settings: str, where: str
) -> RecurrentActorCriticPolicy:
    """Restore the trained policy of a run.

    Parameters
    ----------
    model : dict
        Returned by :func:`train`.
    task : NavigationTask
    learner : LearnerSettings
    settings : str
        Settings that the policy must have been trained with.
    where : str
        Name of the model's file, for messages.

    Raises
    ------
    CheckpointError
        If `model` holds no policy, or one that was trained with other settings.
    """
    check_model(model, where)
    if model["settings"] != settings:
        raise CheckpointError(
            f"{where}: this policy was trained with other settings; "
            "run the workflow, or use the configuration of its run"
        )
    rooms = make_scaled_rooms(task, 1, model["scales"])
    policy = make_policy(rooms.single_observation_space, rooms.single_action_space, learner)
    policy.load_state_dict(model["policy"])
    return policy


def train(run: TrainingRun, checkpoint: Checkpoint) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Train and evaluate to the end of the run, starting from the checkpoint if there is one.

    Parameters
    ----------
    run : TrainingRun
    checkpoint : Checkpoint
        Saved after every segment.

    Returns
    -------
    curve : DataFrame
        One row per evaluation: step, episode_return, success_rate, dead_rate, episode_length,
        episodes.
    model : dict
        action_space, seed, settings and scales of the run, and policy: the weights.
    """
    torch.set_num_threads(1)  # results must not depend on the number of threads
    segment_steps = run.steps // run.checkpoints
    evaluation_rooms = make_scaled_rooms(run.task, len(run.evaluation_seeds), run.scales)
    learner = learner_of_run(run)
    assert learner.env is not None
    curve: list[dict[str, float]] = []
    saved = checkpoint.load()
    if saved is not None:
        learner.policy.load_state_dict(saved["policy"])
        learner.policy.optimizer.load_state_dict(saved["optimizer"])
        curve = saved["curve"]
    segments = range(len(curve), run.checkpoints)
    for segment in progress(segments, f"{run.action_space} {run.seed}", "segment"):
        seed = seed_for(run.root_seed, "navigation", run.action_space, run.seed, segment)
        set_random_seed(seed % 2**32)
        learner.env.seed(seed)
        learner.learn(segment_steps)
        episodes = evaluate(learner.policy, evaluation_rooms, run.evaluation_seeds)
        curve.append(_curve_row((segment + 1) * segment_steps, episodes))
        checkpoint.save(
            dict(
                policy=learner.policy.state_dict(),
                optimizer=learner.policy.optimizer.state_dict(),
                curve=curve,
            )
        )
    model = dict(
        action_space=run.action_space,
        seed=run.seed,
        settings=run.settings,
        scales=dict(run.scales),
        policy=learner.policy.state_dict(),
    )
    return pd.DataFrame(curve), model


def _curve_row(step: int, episodes: Episodes) -> dict[str, float]:
    return dict(
        step=step,
        episode_return=float(episodes.returns.mean()),
        success_rate=episodes.success_rate,
        dead_rate=episodes.dead_rate,
        episode_length=float(episodes.lengths.mean()),
        episodes=len(episodes.returns),
    )
