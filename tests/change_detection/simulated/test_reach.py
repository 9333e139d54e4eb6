"""What a sweeping arm meets."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.change_detection.simulated.reach import (
    MAX_CLEARANCE,
    measure_median_reach,
    measure_reach,
    median_excursion,
)


def test_the_median_excursion_is_that_of_a_random_walk():
    """The maximum of a long random walk has the distribution of the magnitude of its end, whose
    median is 0.674 standard deviations. Of two permuted orders, the larger maximum counts."""
    low, high = median_excursion(1, 2.0, np.random.default_rng(0))
    assert (low, high) == pytest.approx((0, 0), abs=0.1)  # a single step goes up or down, not both
    low, high = median_excursion(400, 1.0, np.random.default_rng(0))
    deviation = np.sqrt(400 / 3)
    assert 0.67 * deviation < high < 1.15 * deviation and low == pytest.approx(-high, rel=0.1)
    doubled = median_excursion(400, 2.0, np.random.default_rng(0))
    assert doubled == pytest.approx((2 * low, 2 * high))


def test_a_sweeping_arm_meets_what_is_in_its_way(pillar_world):
    joint = [j.name for j in pillar_world.robot.joints].index("shoulder_pan_joint")
    start = pillar_world.robot.start_ranges.mean(1)

    def sweep(base, angle, start=start):
        excursion = (-angle, angle)
        simulation = pillar_world.simulation
        return measure_reach(simulation, np.array(base), joint, excursion, ["table"], start)

    narrow, wide = sweep([0.0, 0.0, 0.0], 0.05), sweep([0.0, 0.0, 0.0], 1.0)
    assert narrow.clearance > 0 >= wide.clearance and wide.nearest == "pillar"
    assert narrow.over_low and wide.over_low
    turned_away = sweep([0.0, 0.0, np.pi], 0.05)
    assert turned_away.clearance > narrow.clearance and not turned_away.over_low
    assert sweep([-50.0, 0.0, 0.0], 0.05) == (MAX_CLEARANCE, "", False)
    in_pillar = start.copy()
    in_pillar[joint] += 0.95
    assert sweep([0.0, 0.0, 0.0], 0.05, in_pillar).clearance <= 0

    def is_blocked(*starts):  # for the lower median of the clearances
        reach = measure_median_reach(
            pillar_world.simulation, np.zeros(3), joint, (-0.05, 0.05), ["table"], np.array(starts)
        )
        return reach.clearance <= 0

    assert is_blocked(start, in_pillar)
    assert is_blocked(in_pillar, start, in_pillar)
    assert not is_blocked(start, in_pillar, start)
