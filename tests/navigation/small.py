"""A small task and a small learner for the tests of this package."""

from __future__ import annotations

from sensory_commutativity.navigation.settings import LearnerSettings
from sensory_commutativity.navigation.task import NavigationTask, RewardZone
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import Room
from tests.helpers import DOFS

TASK = NavigationTask(
    Room(objects=2, width=400.0, height=400.0, start_margin=80.0),
    (RewardZone(60.0, 60.0, 55.0, -20.0), RewardZone(330.0, 200.0, 65.0, 50.0)),
    Polyphemus(longitudinal_speed=15.0),
    max_episode_steps=12,
)
LEARNER = LearnerSettings(rooms=4, rollout_steps=16, batch_size=32, epochs=2)
SCALES = dict(zip(DOFS, [1.0, 0.5, 0.0, 0.0, 0.25, 0.0, 0.0, 0.1], strict=True))
