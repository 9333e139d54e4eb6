"""scp/distances.py: distances between two observations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sensory_commutativity.scp.distances import mean_squared_error

views = arrays(np.uint8, (5, 3), elements=st.integers(0, 255))


def test_by_hand():
    first, second = np.array([[0, 10], [20, 30]], np.uint8), np.array([[1, 10], [18, 33]], np.uint8)
    assert mean_squared_error(first, second) == (1 + 0 + 4 + 9) / 4
    assert mean_squared_error(np.array([0.5]), np.array([2.0])) == 2.25
    assert isinstance(mean_squared_error(np.zeros((2, 3, 4)), np.ones((2, 3, 4))), float)


def test_bytes_do_not_wrap_around():
    black, white = np.zeros((64, 3), np.uint8), np.full((64, 3), 255, np.uint8)
    assert mean_squared_error(black, white) == mean_squared_error(white, black) == 255**2


def test_one_level_of_one_pixel_counts():
    first, second = np.zeros((64, 3), np.uint8), np.zeros((64, 3), np.uint8)
    second[63, 2] = 1
    assert mean_squared_error(first, second) == 1 / 192


@given(views, views)
def test_is_symmetric_bounded_and_zero_for_equal_observations_only(a, b):
    distance = mean_squared_error(a, b)
    assert distance == mean_squared_error(b, a)
    assert (distance == 0) == np.array_equal(a, b)
    assert 0 <= distance <= 255**2
    assert mean_squared_error(a, a) == 0


def test_different_shapes_are_refused():
    """NumPy would broadcast some of them."""
    for shape in [(3, 64), (64,), (1, 3), (65, 3)]:
        with pytest.raises(ValueError, match="shapes"):
            mean_squared_error(np.zeros((64, 3)), np.zeros(shape))
