"""statistics/hierarchy.py: the paper's order of the degrees of freedom, as pairs."""

from __future__ import annotations

import pandas as pd
import pytest

from sensory_commutativity.studies.flatland.hierarchy import (
    HIERARCHY,
    LEFT_AND_RIGHT,
    find_difference,
)
from tests.helpers import DOFS

ROWS = pd.DataFrame(
    [("head", "left-elbow", 0.3, 0.1, 0.4, 0.02, 50), ("head", "eyelid", 0.0, -0.1, 0.2, 1.0, 50)],
    columns=["dof_a", "dof_b", "difference", "ci_low", "ci_high", "p_adjusted", "n"],
)


def test_a_pair_the_way_it_stands():
    assert find_difference(ROWS, "head", "left-elbow") == (0.3, 0.1, 0.4, 0.02, 50)


def test_a_pair_the_other_way_round():
    assert find_difference(ROWS, "left-elbow", "head") == (-0.3, -0.4, -0.1, 0.02, 50)


@pytest.mark.parametrize(
    "pair",
    [pair for pairs in HIERARCHY.values() for pair in pairs] + list(LEFT_AND_RIGHT),
    ids="<".join,
)
def test_pairs_are_of_two_dofs_that_exist(pair):
    assert pair[0] != pair[1]
    assert set(pair) <= set(DOFS)


def test_the_hierarchy_has_no_circle():
    """Base and shoulders below elbows, elbows below head and eyelid (section III-C)."""
    rank = dict.fromkeys(
        ("base-longitudinal", "base-rotation", "left-shoulder", "right-shoulder"), 0
    )
    rank |= dict.fromkeys(("left-elbow", "right-elbow"), 1) | dict.fromkeys(("head", "eyelid"), 2)
    assert all(rank[low] + 1 == rank[high] for pairs in HIERARCHY.values() for low, high in pairs)
    assert sum(len(pairs) for pairs in HIERARCHY.values()) == 12
