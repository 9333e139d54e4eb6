"""Settings of the navigation study: what is refused, and with which remedy."""

from __future__ import annotations

import copy

import pytest

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.studies.loading import load, merge, validate
from sensory_commutativity.studies.navigation.builders import check_navigation
from tests.helpers import DEFAULT, ROOT

ZONE = {"x": 120.0, "y": 120.0, "radius": 50.0, "reward": 50.0}
REFUSED = (
    ({"seeds": [0, 1, 2, 2]}, "seeds holds 2 more than once"),
    ({"seeds": [0, 1, 2]}, r"navigation\.seeds"),
    ({"seeds": [0, 1, 2, -1]}, r"navigation\.seeds"),
    ({"action_spaces": ["full", "truncated", "inverse"]}, "action_spaces lacks adapted"),
    ({"action_spaces": ["full", "truncated", "adapted", "full"]}, "holds full more than once"),
    ({"action_spaces": ["full", "truncated", "adapted", "short"]}, r"navigation\.action_spaces"),
    ({"zones": [{**ZONE, "reward": -20.0}]}, "zones holds no goal"),
    ({"zones": [ZONE, {**ZONE, "x": 200.0}]}, "overlaps"),
    ({"zones": [{**ZONE, "x": 20.0}]}, "leaves the room"),
    ({"zones": [{**ZONE, "y": 580.0}]}, "leaves the room"),
    ({"threshold_return": 51.0}, "threshold_return 51 is more than the best reward 50"),
    ({"learner": {"batch_size": 500}}, "batch_size 500"),
    ({"learner": {"batch_size": 192}}, "batch_size 192"),
    ({"learner": {"epoch": 3}}, "epoch: unknown key; did you mean 'epochs'"),
    ({"check_points": 3}, "check_points: unknown key; did you mean 'checkpoints'"),
    ({"world": "nowhere"}, r"navigation\.world names 'nowhere'"),
    ({"agent": "nobody"}, r"navigation\.agent names 'nobody'"),
    ({"scp_world": "nowhere"}, r"navigation\.scp_world names 'nowhere'"),
    ({"agent": "long-arms"}, r"the SCP of 'long-arms' in 'furnished'.*flatland\.variants"),
)
OUT_OF_RANGE = {
    "learner.rooms": 0, "learner.rollout_steps": 3, "learner.batch_size": 3, "learner.epochs": 0,
    "learner.learning_rate": 0.0, "learner.discount": 1.0, "learner.gae_lambda": 1.1,
    "learner.clip_range": 0.0, "learner.entropy_coefficient": -0.1,
    "learner.value_coefficient": -0.1, "learner.max_gradient_norm": 0.0, "learner.features": 0,
    "learner.memory": 0, "learner.initial_log_std": 2.1, "learner.reward_scale": 0.0,
    "max_episode_steps": 0, "steps": 0, "checkpoints": 1, "evaluation_episodes": 1,
    "solved_success_rate": 1.1, "calibration_splits": 9, "zones": [], "action_spaces": ["full"],
    "threshold_return": "25", "world": "Arena", "agent": 3, "scp_world": "no such",
}  # fmt: skip


def test_bad_settings_are_refused_with_their_key(default_settings):
    for changes, message in REFUSED:
        with pytest.raises(ConfigError, match=message):
            validate(merge(default_settings, {"navigation": changes}))
    for key, value in OUT_OF_RANGE.items():
        changes = value
        for part in reversed(key.split(".")):
            changes = {part: changes}
        with pytest.raises(ConfigError, match=rf"^config: navigation\.{key}\b"):
            validate(merge(default_settings, {"navigation": changes}))
    for key, value in {"x": -1.0, "y": 5001.0, "radius": 0.0, "reward": 1001.0}.items():
        settings = copy.deepcopy(default_settings)
        settings["navigation"]["zones"][2][key] = value
        with pytest.raises(ConfigError, match=rf"^config: navigation\.zones\.2\.{key}\b"):
            validate(settings)


def test_limits_themselves_are_accepted(default_settings):
    """Zones may touch each other and the walls; the threshold may be the best reward."""
    zones = [{**ZONE, "x": 50.0, "y": 50.0}, {**ZONE, "x": 150.0, "y": 50.0, "reward": -20.0}]
    changes = {"zones": zones, "threshold_return": 50.0}
    navigation = validate(merge(default_settings, {"navigation": changes})).navigation
    assert len(navigation.zones) == 2 and navigation.threshold_return == 50
    zones[1]["x"] = 149.0
    with pytest.raises(ConfigError, match="overlaps"):
        validate(merge(default_settings, {"navigation": changes}))


def test_the_suggested_number_of_steps_is_accepted(default_settings):
    for steps in (1, 40_961):
        with pytest.raises(ConfigError, match=f"steps {steps} ") as error:
            validate(merge(default_settings, {"navigation": {"steps": steps}}))
        suggested = int(str(error.value).rsplit("set it to ", 1)[1].split()[0])
        config = validate(merge(default_settings, {"navigation": {"steps": suggested}}))
        assert config.navigation.steps == suggested > 0


def test_any_agent_whose_scp_is_measured_may_learn(default_settings):
    flatland = default_settings["flatland"]
    reference = flatland["reference"]
    changes = {"agent": reference["agent"], "scp_world": reference["world"]}
    config = validate(merge(default_settings, {"navigation": changes}))
    assert config.navigation.agent == reference["agent"]
    agents = [agent for agent in flatland["variants"]["agents"] if agent != "sprinter"]
    with pytest.raises(ConfigError, match=r"SCP of 'sprinter' in 'furnished'.*flatland\.variants"):
        validate(merge(default_settings, {"flatland": {"variants": {"agents": agents}}}))


def test_zones_must_leave_space_to_start_and_do_so_in_all_profiles(default_settings):
    corners = [{**ZONE, "x": x, "y": y, "radius": 150.0} for x in (150.0, 450.0)
               for y in (150.0, 450.0)]  # fmt: skip
    zones = [*corners, {"x": 300.0, "y": 300.0, "radius": 60.0, "reward": -1.0}]
    with pytest.raises(ConfigError, match=r"navigation\.zones"):
        check_navigation(validate(merge(default_settings, {"navigation": {"zones": zones}})))
    for profile in ("paper", "test"):
        check_navigation(load(DEFAULT, ROOT / "config" / f"{profile}.yaml"))
