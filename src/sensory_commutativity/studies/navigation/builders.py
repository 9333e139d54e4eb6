"""What the configuration of the navigation study describes: task, action spaces, training runs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import pandas as pd

from ...errors import ConfigError
from ...seeding import generator, seed_for
from ..config import Config
from ..flatland.builders import CHECKED_SITUATIONS, flatland_agent, flatland_room

if TYPE_CHECKING:
    from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy

    from ...navigation.settings import LearnerSettings, TrainingRun
    from ...navigation.task import NavigationEnv, NavigationTask

EVALUATION_ONLY = {
    "seeds", "action_spaces", "calibration_splits", "threshold_return", "solved_success_rate",
    "primary_measure", "alpha", "sensitivity_thresholds", "confirmation_seeds",
}  # fmt: skip
"""Keys of the section `navigation` that no single training run depends on."""


def navigation_task(config: Config) -> NavigationTask:
    """Room, zones, agent and time limit."""
    from ...navigation.task import NavigationTask, RewardZone

    navigation = config.navigation
    return NavigationTask(
        flatland_room(config.flatland, navigation.world),
        tuple(RewardZone(zone.x, zone.y, zone.radius, zone.reward) for zone in navigation.zones),
        flatland_agent(config.flatland, navigation.agent),
        navigation.max_episode_steps,
    )


def navigation_environment(config: Config, render_mode: str | None = None) -> NavigationEnv:
    """The task as a single environment, with the full action space."""
    return navigation_task(config).make_env(render_mode)


def measured_scp(config: Config, scp_table: pd.DataFrame) -> dict[str, float]:
    """SCP of each degree of freedom of the learning agent, as measured by the workflow.

    Parameters
    ----------
    config : Config
    scp_table : DataFrame
        The table flatland_scp or navigation_scp.

    Raises
    ------
    ScpError
        If the table lacks a degree of freedom.
    """
    from ...navigation.action_spaces import scp_from_table

    navigation = config.navigation
    dofs = [dof.name for dof in flatland_agent(config.flatland, navigation.agent).dofs]
    return scp_from_table(
        scp_table, dofs, navigation.scp_world, navigation.agent, config.flatland.sequence_length
    )


def scales_of_run(
    config: Config, scp: Mapping[str, float], action_space: str, seed: int
) -> dict[str, float]:
    """Scale of each degree of freedom in the run `seed` of an action space."""
    from ...navigation.action_spaces import action_scales

    run_seed = seed_for(config.seed, "navigation", action_space, seed)
    return action_scales(action_space, scp, generator(run_seed, "half"))


def evaluation_seeds(config: Config) -> tuple[int, ...]:
    """Seeds of the evaluation episodes, the same for every run."""
    return tuple(
        seed_for(config.seed, "navigation", "evaluation", i)
        for i in range(config.navigation.evaluation_episodes)
    )


def learner_settings(config: Config) -> LearnerSettings:
    """Hyperparameters of the learner."""
    from ...navigation.settings import LearnerSettings

    return LearnerSettings(**config.navigation.learner.model_dump())


def settings_of_run(config: Config, scales: Mapping[str, float]) -> str:
    """Everything that a run depends on, except for its seed and the name of its action space.

    Returns
    -------
    str
        JSON.
    """
    flatland, navigation = config.flatland, config.navigation
    sections = dict(
        world=flatland.worlds[navigation.world],
        agent=flatland.agents[navigation.agent],
        navigation=navigation,
    )
    settings = {
        name: section.model_dump(mode="json", exclude=EVALUATION_ONLY)
        for name, section in sections.items()
    }
    return json.dumps(dict(seed=config.seed, scales=scales, **settings))


def training_run(
    config: Config, action_space: str, seed: int, scales: Mapping[str, float]
) -> TrainingRun:
    """The run `seed` of an action space, ready for :func:`.navigation.training.train`."""
    from ...navigation.settings import TrainingRun

    navigation = config.navigation
    return TrainingRun(
        task=navigation_task(config),
        action_space=action_space,
        seed=seed,
        scales=scales,
        learner=learner_settings(config),
        steps=navigation.steps,
        checkpoints=navigation.checkpoints,
        evaluation_seeds=evaluation_seeds(config),
        root_seed=config.seed,
        settings=settings_of_run(config, scales),
    )


def trained_policy(config: Config, model: dict[str, Any], where: str) -> RecurrentActorCriticPolicy:
    """Restore the policy of `model`, read from the file `where`.

    Raises CheckpointError if it holds none, or one that was trained with other settings.
    """
    from ...navigation.training import check_model, policy_of_run

    check_model(model, where)
    settings = settings_of_run(config, model["scales"])
    return policy_of_run(model, navigation_task(config), learner_settings(config), settings, where)


def check_navigation(config: Config) -> None:
    """Raise ConfigError if the agent finds no start position outside the zones."""
    from ...navigation.task import room_with_zones
    from ...worlds.flatland.room import PlacementError, sample_situation

    task = navigation_task(config)
    room = room_with_zones(task.room, task.zones)
    try:
        for i in range(CHECKED_SITUATIONS):
            rng = generator(config.seed, "check", "navigation", i)
            sample_situation(room, task.agent, rng)
    except PlacementError as error:
        raise ConfigError(
            f"config: navigation.zones leave too little space to start: {error}"
        ) from None
