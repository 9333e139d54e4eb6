"""Transitions: observations before and after an action on one degree of freedom."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...progress import progress
from ...scp.sequences import sample_sequence
from ...seeding import generator, seed_for
from ..config import Config
from .builders import flatland_world


class Transitions(NamedTuple):
    """Sequences of transitions of one degree of freedom.

    Attributes
    ----------
    observations : uint8 (sequences, length + 1, pixels, 3)
    actions : float32 (sequences, length, n_dofs), in [-1, 1]
    """

    observations: np.ndarray
    actions: np.ndarray


def collect_transitions(config: Config, dof: str) -> Transitions:
    """Play sequences of `dof` from random start situations of the reference world.

    All degrees of freedom share the situations.
    """
    flatland = config.flatland
    world = flatland_world(flatland, flatland.reference.world, flatland.reference.agent)
    names = [d.name for d in world.dofs]
    k, length = names.index(dof), flatland.sequence_length
    n = flatland.baselines.transitions // length
    observations = np.empty((n, length + 1, world.agent.pixels, 3), np.uint8)
    actions = np.empty((n, length, len(names)), np.float32)
    for i in progress(range(n), "collecting transitions", "sequence"):
        seed = seed_for(
            config.seed, "transitions", flatland.reference.world, flatland.reference.agent, i
        )
        world.reset(generator(seed, "situation"))
        sequence = sample_sequence(generator(seed, "sequence", dof), length, k, len(names))
        actions[i] = sequence
        observations[i, 0] = world.observe()
        observations[i, 1:] = world.rollout(sequence)
    return Transitions(observations, actions)
