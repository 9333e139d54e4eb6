"""Arrays in HDF5 files: written whole or not at all, checked, with what is said about them, by their hash when they are read.

Every array lies in chunks of one row, compressed, so that any row can be read alone. Masks are kept with eight pixels to a byte.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from ..errors import UserError
from .atomic import atomic_write

FORMAT = 2
REMEDY = "delete it, and run the workflow again"


class StoreError(UserError):
    """A file of arrays cannot be used."""


def write_arrays(
    path: Path, content: str, arrays: Mapping[str, np.ndarray], about: Mapping[str, str]
) -> None:
    """Write named arrays; `content` says what they are, `about` where they come from (names and texts)."""
    whole = io.BytesIO()  # HDF5 itself says much, and unclearly, where a disk is full
    with h5py.File(whole, "w") as file:
        for name, array in arrays.items():
            chunks = (1, *array.shape[1:]) if array.ndim > 2 and len(array) else None
            file.create_dataset(
                name,
                data=array,
                chunks=chunks,
                compression="lzf" if chunks else None,
                track_times=False,
            )
        file.attrs.update(format=FORMAT, content=content, sha256=_digest(arrays, about), **about)
    with atomic_write(path) as temporary:
        temporary.write_bytes(whole.getbuffer())


def read_arrays(path: Path, content: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Read what :func:`write_arrays` wrote: arrays, and what they come from. Raises StoreError with what is wrong and the remedy."""
    if not path.is_file():
        raise StoreError(f"{path}: there is no such file; run the workflow again")
    try:
        with h5py.File(path, "r") as file:
            about = dict(file.attrs)
            if about.get("format") != FORMAT or about.get("content") != content:
                raise StoreError(f"{path}: no file of {content}, or of another version; {REMEDY}")
            arrays = {name: dataset[()] for name, dataset in file.items()}
            expected = about.pop("sha256", None)
    except (OSError, KeyError, ValueError, RuntimeError) as error:
        raise StoreError(
            f"{path}: half written or damaged ({(str(error).splitlines() or ['?'])[0][:80]}); {REMEDY}"
        ) from None
    texts = {name: value for name, value in about.items() if name not in ("format", "content")}
    if _digest(arrays, texts) != expected:
        raise StoreError(f"{path}: damaged, its contents do not fit its hash; {REMEDY}")
    return arrays, texts


def pack(masks: np.ndarray) -> np.ndarray:
    """Masks bool (..., h, w) as uint8 (..., h, ceil(w / 8))."""
    return np.packbits(masks, axis=-1)


def unpack(masks: np.ndarray, width: int) -> np.ndarray:
    """The reverse of :func:`pack`."""
    return np.unpackbits(masks, axis=-1, count=width).astype(bool)


def _digest(arrays: Mapping[str, np.ndarray], texts: Mapping[str, object]) -> str:
    content = hashlib.sha256(repr(sorted(texts.items())).encode())
    for name in sorted(arrays):
        content.update(f"{name} {arrays[name].shape} {arrays[name].dtype}".encode())
        content.update(np.ascontiguousarray(arrays[name]).tobytes())
    return content.hexdigest()
