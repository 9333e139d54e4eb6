"""Small models and synthetic pairs for the tests of change detection."""

from __future__ import annotations

import numpy as np

from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.pair_files import Pairs

IDENTICAL, DIFFERENT, MOVED = range(3)
SMALL_RAFT = dict(
    widths=(8, 12, 16, 16, 24),
    hidden=16,
    context=16,
    updates=2,
    quarter_channels=12,
    half_channels=8,
)
SMALL = {"raft": SMALL_RAFT, "flownet": dict(scale=0.05)}
"""Arguments that make small models, by name."""


def make_pairs(n: int = 6, size: int = 128) -> Pairs:
    """Noise, in turn of each outcome; a bright square moves in the pairs that are "moved"."""
    rng = np.random.default_rng(0)
    pictures = rng.integers(60, 120, (n, 2, size, size, 3)).astype(np.uint8)
    masks = np.zeros((n, 2, size, size), bool)
    outcome = (np.arange(n) % 3).astype(np.int8)
    for i in range(n):
        if outcome[i] == DIFFERENT:
            masks[i] = True
        else:
            pictures[i, 1] = pictures[i, 0]
        if outcome[i] == MOVED:
            for view, left in enumerate((20, 70)):
                masks[i, view, 30:50, left : left + 20] = True
            pictures[i][masks[i]] = 250
    kinds = tuple(OUTCOMES[k] for k in outcome)
    return Pairs(pictures, masks, outcome, kinds, np.arange(n, dtype=np.int32) // 3)
