"""Files of arrays are read as they were written, or refused."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from sensory_commutativity.storage.arrays import (
    ArrayFileError,
    pack_masks,
    read_arrays,
    unpack_masks,
    write_arrays,
)
from tests.storage.rehash import rehash

ARRAYS = {
    "pictures": np.arange(6000, dtype=np.uint8).reshape(10, 20, 30),
    "different": np.arange(12).reshape(4, 3) % 2 == 0,
    "clearance": np.array([0.5, -0.25, np.nan]),
    "empty": np.zeros((0, 4, 5), np.float32),
}
METADATA = {"rooms": "kitchen", "dof": "elbow"}


def test_arrays_and_metadata_are_read_as_they_were_written(tmp_path):
    path = tmp_path / "a.h5"
    write_arrays(path, "pairs", ARRAYS, METADATA)
    arrays, metadata = read_arrays(path, "pairs")
    assert metadata == METADATA and arrays.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        assert arrays[name].dtype == array.dtype, name
        assert np.array_equal(arrays[name], array, equal_nan=array.dtype == float), name
    first = path.read_bytes()
    write_arrays(path, "pairs", ARRAYS, METADATA)
    assert path.read_bytes() == first and list(tmp_path.iterdir()) == [path]


def test_a_missing_damaged_or_other_file_is_refused_with_the_reason(tmp_path):
    path = tmp_path / "a.h5"

    def check(reason: str) -> None:
        with pytest.raises(ArrayFileError, match=reason) as error:
            read_arrays(path, "pairs")
        assert str(error.value).startswith(f"{path}: ")

    check("there is no such file")
    write_arrays(path, "tuples", ARRAYS, METADATA)
    check("no file of pairs")
    write_arrays(path, "pairs", ARRAYS, METADATA)
    data = path.read_bytes()
    with h5py.File(path, "a") as file:
        file.attrs["format"] = -1
    check("damaged")
    rehash(path)
    check("another version")
    flipped = bytearray(data)
    flipped[data.index(bytes(range(40, 60)))] ^= 64  # in the pictures
    damaged = {
        "truncated": data[: len(data) // 2],
        "pictures": bytes(flipped),
        "metadata": data.replace(b"kitchen", b"xitchen"),
        "text": b"not HDF5",
        "empty": b"",
    }
    for content in damaged.values():
        path.write_bytes(content)
        check("damaged")


def test_packed_masks_are_unpacked_to_their_width():
    rng = np.random.default_rng(0)
    for width in (8, 13, 128):
        masks = rng.uniform(size=(3, 2, 5, width)) < 0.5
        packed = pack_masks(masks)
        assert packed.dtype == np.uint8 and packed.shape == (3, 2, 5, -(-width // 8))
        assert np.array_equal(unpack_masks(packed, width), masks), width
