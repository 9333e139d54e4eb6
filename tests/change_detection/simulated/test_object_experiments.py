"""SC-experiments on objects and their labels."""

from __future__ import annotations

import numpy as np

from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.simulated.object_experiments import (
    COMPARISONS,
    ObjectExperimentRunner,
    assemble_tuples,
)
from sensory_commutativity.storage.arrays import unpack_masks

IDENTICAL, DIFFERENT, MOVED = range(len(OUTCOMES))
SHOULDER_PAN = 3  # of Fetch's degrees of freedom


def test_experiments_are_labelled_and_their_alternatives_are_played(make_sampler):
    sampler = make_sampler(0, (45.0, 90.0), False)
    runner = ObjectExperimentRunner(sampler, SHOULDER_PAN, 20, alternatives=True)
    tuples = assemble_tuples([runner.play() for _ in range(10)], sampler)
    assert tuples["pictures"].shape == (10, 2, len(COMPARISONS), 2, 128, 128, 3)
    assert tuples["outcome"].shape == (10, 2, len(COMPARISONS))
    masked = unpack_masks(tuples["masks"], 128).mean((-3, -2, -1))
    assert (masked[tuples["outcome"] == IDENTICAL] == 0).all()
    assert (masked[tuples["outcome"] == DIFFERENT] == 1).all()
    moved = masked[tuples["outcome"] == MOVED]
    assert ((moved > 0) & (moved < 1)).all()
    assert set(tuples["outcome"][:, :, 0].ravel()) >= {IDENTICAL, DIFFERENT}
    untouched = ~tuples["touched_fixed"] & (tuples["moved"][:, 0] == 0)
    assert untouched.any()
    assert (tuples["outcome"][untouched, :, 0] == IDENTICAL).all()  # free space commutes
    assert (tuples["touched_fixed"] | ~tuples["touched_fixed_first"]).all()
    both_orders = ObjectExperimentRunner(sampler, SHOULDER_PAN, 6)
    tuples = assemble_tuples([both_orders.play()], sampler)
    assert tuples["pictures"].shape == (1, 2, 1, 2, 128, 128, 3)


def test_a_robot_returns_to_its_start_unless_something_is_in_the_way(make_sampler):
    sampler = make_sampler(2, randomize=False)
    runner = ObjectExperimentRunner(sampler, SHOULDER_PAN, 20, alternatives=True)
    experiments = [runner.play() for _ in range(6)]
    free = [e for e in experiments if not e.touched_fixed_first and not len(e.displaced[1])]
    assert free
    for experiment in free:
        begin, returned = experiment.views[COMPARISONS.index("return")]
        assert np.allclose(begin.camera_pose, returned.camera_pose, atol=1e-3)
        segmentation = (view.pictures[0].segmentation for view in (begin, returned))
        assert np.mean(np.not_equal(*segmentation)) < 0.01
