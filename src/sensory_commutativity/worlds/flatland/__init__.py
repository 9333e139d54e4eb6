"""Flatland: a one-eyed agent in a two-dimensional room, on pymunk (paper, section III-A).

Importing this package registers the Gymnasium environment ``SensoryCommutativity/Flatland-v0``.
"""

import gymnasium

from .environment import ENVIRONMENT_ID, MAX_EPISODE_STEPS

if ENVIRONMENT_ID not in gymnasium.registry:
    gymnasium.register(
        ENVIRONMENT_ID,
        entry_point="sensory_commutativity.worlds.flatland.environment:FlatlandEnv",
        vector_entry_point="sensory_commutativity.worlds.flatland.vector:FlatlandVectorEnv",
        max_episode_steps=MAX_EPISODE_STEPS,
    )
