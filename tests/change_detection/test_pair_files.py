"""Files of pairs are read as they were written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sensory_commutativity.change_detection.outcome import OUTCOMES
from sensory_commutativity.change_detection.pair_files import (
    CONTENT,
    Pairs,
    pairs_to_arrays,
    read_pairs,
)
from sensory_commutativity.change_detection.simulated.pairs import Pair
from sensory_commutativity.storage.arrays import ArrayFileError, write_arrays
from tests.change_detection.examples import make_pairs


def write(path: Path, pairs: Pairs, first: int, last: int) -> None:
    chosen = [
        Pair(pairs.pictures[i], pairs.masks[i], OUTCOMES[pairs.outcome[i]], pairs.kind[i])
        for i in range(first, last)
    ]
    write_arrays(path, CONTENT, *pairs_to_arrays(chosen, pairs.scene[first:last].tolist()))


def test_several_files_are_read_as_one_data_set(tmp_path):
    pairs = make_pairs()
    write(tmp_path / "a.h5", pairs, 0, 4)
    write(tmp_path / "b.h5", pairs, 4, 6)
    read = read_pairs(tmp_path / "a.h5", tmp_path / "b.h5")
    for name, expected, values in zip(Pairs._fields, pairs, read, strict=True):
        assert np.array_equal(expected, values), name
        assert isinstance(values, tuple) or values.dtype == expected.dtype, name

    write(tmp_path / "64.h5", make_pairs(3, 64), 0, 3)
    with pytest.raises(ArrayFileError, match="pictures of several sizes"):
        read_pairs(tmp_path / "a.h5", tmp_path / "64.h5")
