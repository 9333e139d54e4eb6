"""Object and furniture types have plausible sizes; the two object families are disjoint."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity.worlds.apartment.scenes.furniture import FURNITURE
from sensory_commutativity.worlds.apartment.scenes.objects import (
    FAMILIES,
    OBJECTS,
    list_object_types,
)

WITHOUT_SOLIDS = ("rug", "picture", "window")


def test_the_families_are_disjoint_and_large_enough():
    training, testing = (set(list_object_types(family)) for family in FAMILIES)
    assert training | testing == set(OBJECTS)
    assert not training & testing
    assert min(len(training), len(testing)) >= 8


def test_objects_have_plausible_sizes_and_masses():
    for name, kind in OBJECTS.items():
        vertices = np.concatenate([part.mesh.vertices for part in kind.parts])
        size = np.ptp(vertices, axis=0)
        assert 0.03 < size.max() < 0.5, name
        assert 0.1 <= kind.mass <= 4, name
        assert kind.mass / size.prod() < 2_500, name  # kg per cubic metre: lighter than stone
        assert vertices[:, 2].min() == pytest.approx(-kind.half_height, abs=1e-3), name


def test_furniture_fits_its_size():
    for name, kind in FURNITURE.items():
        blocks = kind.build(kind.size, kind.colour, kind.texture)
        half = np.array(
            [(b.size[0], b.size[0], b.size[1]) if b.kind == "cylinder" else b.size for b in blocks]
        )
        centre = np.array([block.centre for block in blocks])
        low, high = (centre - half).min(0), (centre + half).max(0)
        assert (half > 0).all(), name
        assert (high[:2] <= np.array(kind.size[:2]) / 2 + 0.06).all(), name
        assert (low[:2] >= -np.array(kind.size[:2]) / 2 - 0.06).all(), name
        assert low[2] >= -0.13, name
        assert any(block.solid for block in blocks) != (name in WITHOUT_SOLIDS), name
