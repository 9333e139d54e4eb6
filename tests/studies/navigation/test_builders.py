"""What the configuration of the navigation study describes."""

from __future__ import annotations

import json
from dataclasses import asdict

import numpy as np
import pandas as pd
import pytest
from gymnasium.utils.env_checker import check_env

from sensory_commutativity.navigation.settings import LearnerSettings
from sensory_commutativity.storage.checkpoints import CheckpointError
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import merge, validate
from sensory_commutativity.studies.navigation.builders import (
    evaluation_seeds,
    learner_settings,
    measured_scp,
    navigation_environment,
    navigation_task,
    scales_of_run,
    settings_of_run,
    trained_policy,
    training_run,
)
from sensory_commutativity.studies.navigation.config import LearnerConfig
from tests.helpers import DOFS

SCALES = dict(zip(DOFS, [1.0, 0.5, 0.0, 0.0, 0.25, 0.0, 0.0, 0.1], strict=True))


def overlay(config: Config, **sections) -> Config:
    return validate(merge(config.model_dump(mode="json"), sections))


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_the_default_task_is_that_of_the_paper(default_config):
    task = navigation_task(default_config)
    assert task.room.width == task.room.height and task.agent.longitudinal_speed == 15
    assert sorted(zone.reward for zone in task.zones) == [-20, -20, -20, 50]
    check_env(navigation_environment(default_config), skip_render_check=True)


def test_a_training_run_has_the_settings_of_the_configuration(default_config):
    config = overlay(default_config, navigation={"learner": {"memory": 32, "gae_lambda": 0.9}})
    assert learner_settings(config) == LearnerSettings(memory=32, gae_lambda=0.9)
    assert asdict(LearnerSettings()) == LearnerConfig().model_dump()
    run, navigation = training_run(config, "adapted", 3, SCALES), config.navigation
    assert (run.action_space, run.seed, run.scales) == ("adapted", 3, SCALES)
    assert (run.steps, run.checkpoints) == (navigation.steps, navigation.checkpoints)
    assert run.task == navigation_task(config) and run.learner == learner_settings(config)
    assert run.evaluation_seeds == evaluation_seeds(config) and run.root_seed == config.seed
    assert len(set(run.evaluation_seeds)) == navigation.evaluation_episodes
    assert json.loads(run.settings)["navigation"]["learner"]["memory"] == 32


def test_random_halves_differ_between_runs_and_repeat(default_config):
    scp = dict.fromkeys("abcdefgh", 0.5)

    def half(seed: int) -> tuple[float, ...]:
        return tuple(scales_of_run(default_config, scp, "random-half", seed).values())

    halves = [half(seed) for seed in range(12)]
    assert halves == [half(seed) for seed in range(12)]
    assert all(sum(scales) == 4 for scales in halves) and len(set(halves)) > 6


def test_measured_scps_are_those_of_the_learning_agent_in_the_order_of_its_actions(default_config):
    navigation, length = default_config.navigation, default_config.flatland.sequence_length
    rows = dict(agent=navigation.agent, length=length, dof=DOFS[::-1], threshold=0.0)
    scp = np.linspace(0.1, 0.9, len(DOFS))
    wanted = pd.DataFrame(rows | dict(world=navigation.scp_world, scp=scp[::-1]))
    other = pd.DataFrame(rows | dict(world="another", scp=0.3))
    result = measured_scp(default_config, pd.concat([other, wanted]))
    assert list(result.items()) == list(zip(DOFS, scp.tolist(), strict=True))


def test_settings_of_a_run_change_with_everything_that_it_depends_on(default_config):
    navigation = default_config.navigation
    reference = settings_of_run(default_config, SCALES)
    for change in (
        {"navigation": {"steps": navigation.steps * 2}},
        {"navigation": {"checkpoints": navigation.checkpoints - 1}},
        {"navigation": {"zones": [{"x": 120.0, "y": 120.0, "radius": 81.0, "reward": 50.0}]}},
        {"navigation": {"evaluation_episodes": navigation.evaluation_episodes + 1}},
        {"navigation": {"learner": {"learning_rate": 0.002}}},
        {"navigation": {"max_episode_steps": navigation.max_episode_steps + 1}},
        {"seed": default_config.seed + 1},
        {"flatland": {"worlds": {navigation.world: {"width": 640.0}}}},
        {"flatland": {"agents": {navigation.agent: {"arm_length": 45.0}}}},
    ):
        assert settings_of_run(overlay(default_config, **change), SCALES) != reference, change
    assert settings_of_run(default_config, {**SCALES, "head": 0.001}) != reference
    for change in (
        {"seeds": [0, 1, 2, 3, 4]},
        {"action_spaces": ["full", "truncated", "adapted"]},
        {"threshold_return": 3.0},
        {"calibration_splits": 99},
        {"solved_success_rate": 0.5},
    ):
        config = overlay(default_config, navigation=change)
        assert settings_of_run(config, SCALES) == reference, change


def test_policies_of_other_settings_are_rejected(default_config):
    with pytest.raises(CheckpointError, match=r"full\.0\.policy: no trained policy"):
        trained_policy(default_config, {"policy": {}}, "full.0.policy")
    settings = settings_of_run(overlay(default_config, seed=default_config.seed + 1), SCALES)
    model = {"settings": settings, "scales": SCALES, "policy": {}}
    with pytest.raises(CheckpointError, match=r"full\.0\.policy: .*other settings"):
        trained_policy(default_config, model, "full.0.policy")
