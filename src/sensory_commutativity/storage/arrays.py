"""Arrays in HDF5 files with metadata, written atomically and checked by their hash when read.

Arrays of three and more dimensions are stored in compressed chunks of one row, so that any row can
be read alone. Masks are packed into eight pixels per byte.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from ..errors import UserError
from .atomic import atomic_write

FORMAT = 2
"""Version of the layout below; files of other versions are refused."""
REMEDY = "delete it, and run the workflow again"


class ArrayFileError(UserError):
    """A file of arrays is missing, damaged or of another kind."""


def write_arrays(
    path: Path, content: str, arrays: Mapping[str, np.ndarray], metadata: Mapping[str, str]
) -> None:
    """Write named arrays to an HDF5 file.

    Parameters
    ----------
    path : Path
    content : str
        Kind of file, such as ``pairs``; :func:`read_arrays` refuses other kinds.
    arrays : mapping of str to array
    metadata : mapping of str to str
        For example the provenance of the arrays.
    """
    buffer = io.BytesIO()  # on a full disk, HDF5 itself raises long and unclear errors
    with h5py.File(buffer, "w") as file:
        for name, array in arrays.items():
            chunks = (1, *array.shape[1:]) if array.ndim > 2 and len(array) else None
            file.create_dataset(
                name,
                data=array,
                chunks=chunks,
                compression="lzf" if chunks else None,
                track_times=False,
            )
        digest = _hash(arrays, metadata)
        file.attrs.update(format=FORMAT, content=content, sha256=digest, **metadata)
    with atomic_write(path) as temporary:
        temporary.write_bytes(buffer.getbuffer())


def read_arrays(path: Path, content: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Read the arrays and the metadata that :func:`write_arrays` wrote.

    Raises ArrayFileError if the file is missing, damaged, of another version or of another
    `content`.
    """
    with _open(path, content) as file:
        arrays = {name: dataset[()] for name, dataset in file.items()}
        metadata, digest = _metadata(file), file.attrs.get("sha256")
    if _hash(arrays, metadata) != digest:
        raise ArrayFileError(f"{path}: damaged, its content does not match its hash; {REMEDY}")
    return arrays, metadata


def read_array_metadata(path: Path, content: str) -> dict[str, str]:
    """Read the metadata alone, without checking the hash; raises ArrayFileError as above."""
    with _open(path, content) as file:
        return _metadata(file)


@contextmanager
def _open(path: Path, content: str) -> Iterator[h5py.File]:
    """Open a file of this content; the block reads from it."""
    if not path.is_file():
        raise ArrayFileError(f"{path}: there is no such file; run the workflow again")
    try:
        with h5py.File(path, "r") as file:
            if (file.attrs.get("format"), file.attrs.get("content")) != (FORMAT, content):
                raise ArrayFileError(
                    f"{path}: no file of {content}, or of another version; {REMEDY}"
                )
            yield file
    except (OSError, KeyError, ValueError, RuntimeError) as error:
        reason = (str(error).splitlines() or ["?"])[0][:80]
        raise ArrayFileError(f"{path}: incomplete or damaged ({reason}); {REMEDY}") from None


def _metadata(file: h5py.File) -> dict[str, str]:
    return {key: v for key, v in file.attrs.items() if key not in ("format", "content", "sha256")}


def pack_masks(masks: np.ndarray) -> np.ndarray:
    """Pack masks, bool (..., h, w), into bits: uint8 (..., h, ceil(w / 8))."""
    return np.packbits(masks, axis=-1)


def unpack_masks(packed: np.ndarray, width: int) -> np.ndarray:
    """Invert :func:`pack_masks`: bool (..., h, width)."""
    return np.unpackbits(packed, axis=-1, count=width).astype(bool)


def _hash(arrays: Mapping[str, np.ndarray], metadata: Mapping[str, object]) -> str:
    digest = hashlib.sha256(repr(sorted(metadata.items())).encode())
    for name in sorted(arrays):
        digest.update(f"{name} {arrays[name].shape} {arrays[name].dtype}".encode())
        digest.update(np.ascontiguousarray(arrays[name]).tobytes())
    return digest.hexdigest()
