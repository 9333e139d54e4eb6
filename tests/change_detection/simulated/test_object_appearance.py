"""Randomised sizes and colours of objects and scenes."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.change_detection.simulated.object_appearance import (
    recolour_scene,
    sample_object,
)
from sensory_commutativity.worlds.apartment.scenes.scene import Movable


def test_a_randomised_object_has_the_mass_and_the_collision_shapes_of_its_size():
    n_randomised = 0
    for seed in range(60):
        original, randomised = (
            sample_object("o", "training", (0.0, 0.0, 0.5), np.random.default_rng(seed), randomize)
            for randomize in (False, True)
        )
        factors = measure_extent(randomised) / measure_extent(original)
        assert factors[0] == pytest.approx(factors[1])  # round objects stay round
        assert randomised.mass == pytest.approx(original.mass * factors.prod())
        for old, new in zip(original.solids, randomised.solids, strict=True):
            assert new.position == pytest.approx(np.array(old.position) * factors)
            if old.kind == "box":
                assert new.size == pytest.approx(np.array(old.size) * factors)
            elif old.kind == "cylinder":
                assert new.size == pytest.approx(np.array(old.size) * factors[[0, 2]])
            elif old.kind == "sphere":
                assert factors[2] == pytest.approx(factors[0])
                assert new.size == pytest.approx(np.array(old.size) * factors[0])
            else:
                assert new.vertices == pytest.approx(old.vertices * factors)
        n_randomised += not np.allclose(factors, 1)
    assert 15 < n_randomised < 45  # half of them


def measure_extent(movable: Movable) -> np.ndarray:
    return np.ptp(np.concatenate([part.mesh.vertices for part in movable.parts]), axis=0)


def test_a_recoloured_scene_has_the_same_shapes(make_sampler):
    scene = make_sampler(0, randomize=False).scene
    recoloured = recolour_scene(scene, np.random.default_rng(0))
    changed = 0
    for before, after in zip(
        (*scene.fixtures, *scene.movables),
        (*recoloured.fixtures, *recoloured.movables),
        strict=True,
    ):
        assert before.solids == after.solids
        for old, new in zip(before.parts, after.parts, strict=True):
            assert old.mesh is new.mesh and all(0 <= c <= 1 for c in new.colour)
            changed += old.colour != new.colour
    assert changed
