"""Noise of sensors, actuators and the reset."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity import ArgumentError, World, check_world, measure
from sensory_commutativity.adapters.noise import NoisyWorld
from sensory_commutativity.scp.experiment import compare_orders
from sensory_commutativity.worlds.corridor import Corridor
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import FREE_SPACE, drive, reset_world


def test_without_noise_it_is_the_world_within():
    world = NoisyWorld(Corridor(wall=1))
    assert isinstance(world, World)
    assert np.array_equal(
        measure(world, n=20, length=5).distances,
        measure(Corridor(wall=1), n=20, length=5).distances,
    )


def test_noise_has_the_size_that_was_asked_for():
    world = reset_world(NoisyWorld(Corridor(), sensor=2.0))
    seen = np.array([world.observe() for _ in range(2000)])
    np.testing.assert_allclose(seen.std(axis=0), 2.0, rtol=0.1)

    view = reset_world(NoisyWorld(FlatlandWorld(FREE_SPACE), sensor=500.0)).observe()
    assert view.dtype == np.uint8 and {0, 255} <= set(view.ravel().tolist())

    flat = FlatlandWorld(FREE_SPACE)
    world = reset_world(NoisyWorld(flat, actuator=0.1))
    start, ends = world.snapshot(), []
    for _ in range(300):
        world.restore(start)
        world.play(drive("head", 0.5, 4))
        ends.append(flat.controller_state[7] / 0.25)  # rad per action of 1
    assert np.mean(ends) == pytest.approx(2.0, abs=0.02)
    assert np.std(ends) == pytest.approx(0.1 * 0.5 * 4**0.5, rel=0.15)

    world = reset_world(NoisyWorld(flat, reset=0.3))
    start, headings = world.snapshot(), []
    for _ in range(300):
        world.restore(start)
        headings.append(flat.controller_state[7] / 0.25)
    assert np.std(headings) == pytest.approx(0.3, rel=0.15)


def test_a_reset_determines_the_noise_and_a_restore_does_not_repeat_it():
    world = NoisyWorld(FlatlandWorld(FREE_SPACE), sensor=3.0, actuator=0.1, reset=0.1)
    sequence = np.random.default_rng(0).uniform(-1, 1, (5, 8))
    ends = []
    for _ in range(2):
        reset_world(world, 7)
        ends.append(compare_orders(world, world.snapshot(), sequence, sequence))
    assert all(np.array_equal(a, b) for a, b in zip(*ends, strict=True))
    assert not np.array_equal(ends[0].first, ends[0].second)
    assert not check_world(world, tries=2).passed


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf"), True])
def test_a_wrong_size_is_refused(value):
    with pytest.raises(ArgumentError, match=r"sensor: expected a number of at least 0"):
        NoisyWorld(Corridor(), sensor=value)
