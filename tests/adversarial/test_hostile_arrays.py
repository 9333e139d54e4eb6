"""HDF5 files can link to other files, declare any size, and expand without end: all is refused."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

from sensory_commutativity.change_detection.pair_files import read_pairs
from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.origin import read_origin
from sensory_commutativity.runs.verify import verify_run
from sensory_commutativity.storage.arrays import (
    FORMAT,
    USER_BLOCK,
    read_array_metadata,
    read_arrays,
    write_arrays,
)
from tests.storage.rehash import rehash

SECONDS, MEGABYTES = 2.0, 300


def hostile_contents(secret: Path) -> Iterator[tuple[str, Callable[[h5py.File], object]]]:
    """What each file holds, and a function that writes it."""
    other = str(secret)
    data = np.zeros(2, np.uint8)

    def dataset(**options) -> Callable[[h5py.File], object]:
        return lambda file: file.create_dataset("pictures", **options)

    yield "external storage", dataset(shape=(2,), dtype="u1", external=[(other, 0, 2)])
    yield "a link to a file", lambda file: file.update(pictures=h5py.ExternalLink(other, "/x"))
    yield "a soft link", lambda file: file.update(pictures=h5py.SoftLink("/y"))
    yield "a group", lambda file: file.create_group("pictures")
    yield "a type", lambda file: file.update(pictures=np.dtype("f8"))
    yield "6 GB, none stored", dataset(shape=(6000, 10**6), dtype="u1", chunks=(1, 10**6))
    yield (
        "6 GB in chunks, none stored",
        dataset(shape=(6000, 10, 10**5), dtype="u1", chunks=(1, 10, 10**5), compression="lzf"),
    )
    yield "one piece, none stored", dataset(shape=(10**9,), dtype="u1")
    yield "tiny chunks", dataset(data=np.zeros((9, 9, 9)), chunks=(1, 1, 1), compression="lzf")
    yield (
        "gzip",
        dataset(data=np.zeros((4, 1000, 1000)), chunks=(1, 1000, 1000), compression="gzip"),
    )
    yield "texts", dataset(data=["a" * 1000] * 9)
    yield "compounds", dataset(data=np.zeros(3, [("a", "f8"), ("b", "i4")]))
    yield "references", dataset(shape=(3,), dtype=h5py.ref_dtype)
    yield "nothing", dataset(data=h5py.Empty("f4"))
    yield "an array as metadata", lambda file: file.attrs.update(kinds=data)
    yield "a million texts", lambda file: file.attrs.update({f"t{i}": "a" for i in range(60)})
    yield "many arrays", lambda file: file.update({f"a{i}": data for i in range(60)})

    def virtual(file: h5py.File) -> None:
        layout = h5py.VirtualLayout((2,), "u1")
        layout[:] = h5py.VirtualSource(other, "x", (2,))
        file.create_virtual_dataset("pictures", layout)

    yield "a virtual array", virtual


def write_hostile(path: Path, fill: Callable[[h5py.File], object], block: bool) -> None:
    with h5py.File(path, "w", **({"userblock_size": USER_BLOCK} if block else {})) as file:
        file.attrs.update(format=FORMAT if block else 2, content="mask_pairs", sha256="0" * 64)
        fill(file)
    if block:
        rehash(path)


@pytest.mark.parametrize("block", [True, False])
def test_whatever_is_no_array_in_the_file_itself_is_refused(tmp_path, block):
    (tmp_path / "secret").write_bytes(b"secret of somebody else")
    path = tmp_path / "run" / "tables" / "a.h5"
    path.parent.mkdir(parents=True)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for what, fill in hostile_contents(tmp_path / "secret"):
        write_hostile(path, fill, block)
        start = time.monotonic()
        for read in (read_arrays, read_array_metadata):
            with pytest.raises(UserError) as caught:
                pytest.fail(f"{what}: {read(path, 'mask_pairs')}")
            message = str(caught.value)
            assert message.startswith(f"{path}: ") and message.isprintable(), what
        with pytest.raises(UserError):
            read_origin(path)
        (bad,) = verify_run(tmp_path / "run").bad
        assert bad.status == "damaged", what
        assert time.monotonic() - start < SECONDS, what
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert used < MEGABYTES * 1024


def test_files_without_the_arrays_or_texts_that_are_needed_are_refused(tmp_path):
    path = tmp_path / "a.h5"
    pictures = np.zeros((2, 2, 16, 16, 3), np.uint8)
    masks, small = np.zeros((2, 2, 16, 2), np.uint8), np.zeros(2, np.int8)
    whole = dict(pictures=pictures, masks=masks, outcome=small, kind=small, scene=small)
    kinds = {"kinds": '["random"]'}
    write_arrays(path, "mask_pairs", whole, kinds)
    assert len(read_pairs(path).pictures) == 2
    wrong_arrays = [{k: v for k, v in whole.items() if k != name} for name in whole]
    wrong_arrays += [{**whole, name: array[:1]} for name, array in whole.items()]
    wrong_arrays += [
        {**whole, "kind": small + 5}, {**whole, "outcome": small + 5},
        {**whole, "outcome": small - 1}, {**whole, "pictures": pictures[..., :1]},
        {**whole, "masks": masks.astype(float)}, {**whole, "pictures": pictures[0]}, {},
    ]  # fmt: skip
    cases = [(arrays, kinds) for arrays in wrong_arrays]
    cases += [(whole, texts) for texts in ({}, {"kinds": "no JSON"}, {"kinds": "[1]"},
                                           {"kinds": "[" * 5000}, {"kinds": "{}"})]  # fmt: skip
    for arrays, texts in cases:
        write_arrays(path, "mask_pairs", arrays, texts)
        with pytest.raises(UserError) as caught:
            pytest.fail(f"{list(arrays)} {texts}: {read_pairs(path).outcome}")
        assert str(caught.value).startswith(f"{path}: ")
