"""Pairs of pictures have the outcome that was asked for."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.change_detection.outcome import MIN_VISIBLE_PIXELS, OUTCOMES
from sensory_commutativity.change_detection.simulated import pairs as module
from sensory_commutativity.change_detection.simulated.pairs import PairFactory
from sensory_commutativity.errors import UserError


def test_pairs_have_the_outcome_that_was_asked_for(make_sampler, monkeypatch):
    factory = PairFactory(make_sampler(0))
    masked = {"identical": 0, "different": 1}  # fraction of the pixels
    for outcome in OUTCOMES:
        for _ in range(12):
            pair = factory.make_pair(outcome)
            assert pair.outcome == outcome and pair.pictures.shape == (2, 128, 128, 3)
            assert (pair.pictures[0] != pair.pictures[1]).any()  # they are never byte-identical
            if outcome in masked:
                assert pair.masks.mean() == masked[outcome]
                continue
            assert MIN_VISIBLE_PIXELS <= pair.masks.sum() < 0.9 * pair.masks.size
            change = np.abs(pair.pictures[0].astype(int) - pair.pictures[1]).max(-1)
            moved = pair.masks.any(0)
            assert change[moved].mean() > change[~moved].mean()
    monkeypatch.setattr(module, "MAX_SITUATIONS", 2)
    monkeypatch.setattr(factory, "_make_moved", lambda: None)
    with pytest.raises(UserError, match=r"none of 2 situations gives a pair .* 'moved'"):
        factory.make_pair("moved")


def test_equal_seeds_make_equal_pairs(make_sampler):
    first, second, other = (
        PairFactory(make_sampler(seed)).make_pair("moved") for seed in (1, 1, 2)
    )
    assert np.array_equal(first.pictures, second.pictures)
    assert np.array_equal(first.masks, second.masks)
    assert not np.array_equal(first.pictures, other.pictures)
