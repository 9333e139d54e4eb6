"""Arrays in HDF5 files with metadata, written atomically and checked by their hash when read.

A file begins with a user block of text that holds the SHA-256 of the rest, which is checked before
HDF5 sees any of it. Arrays of three and more dimensions are stored in compressed chunks of one row,
all others in one piece; whatever else HDF5 can hold (links, data in other files, other filters) is
refused, so that the size of an array is known before memory is taken. Masks are packed into eight
pixels per byte.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..errors import UserError
from .atomic import atomic_write
from .files import check_regular_file, printable

FORMAT = 3
"""Version of the layout below that is written."""
UNBLOCKED_FORMAT = 2
"""Earlier version without a user block; still read, by the hash of its arrays and metadata."""
USER_BLOCK = 512
"""Bytes; HDF5's smallest."""
_HEADER = re.compile(rb"sensory-commutativity arrays; sha256 of the rest: ([0-9a-f]{64})\n\0*")
MAX_BYTES = 600_000_000
"""Size of a file, and of all its arrays; chosen: three times the largest of the paper's sizes."""
MAX_RATIO = 100
"""Largest compression; LZF replaces at most 264 bytes by 3."""
MAX_ARRAYS, MAX_TEXTS, MAX_TEXT_BYTES = 50, 50, 1_000_000
"""Arrays in a file, texts in its metadata, and bytes of a text; chosen: far more than ours have."""
REMEDY = "delete it, and run the workflow again"


class ArrayFileError(UserError):
    """A file of arrays is missing, damaged or of another kind."""


class StoredArrays(dict[str, np.ndarray]):
    """Arrays by name. One that is asked for and missing raises ArrayFileError."""

    def __init__(self, path: Path, arrays: Mapping[str, np.ndarray]):
        super().__init__(arrays)
        self._path = path

    def __missing__(self, name: str) -> np.ndarray:
        raise ArrayFileError(f"{self._path}: has no array {name!r}; {REMEDY}")


class StoredTexts(dict[str, str]):
    """Texts by name. One that is asked for and missing raises ArrayFileError."""

    def __init__(self, path: Path, texts: Mapping[str, str]):
        super().__init__(texts)
        self._path = path

    def __missing__(self, name: str) -> str:
        raise ArrayFileError(f"{self._path}: has no text {name!r}; {REMEDY}")

    def json_list(self, name: str) -> list[str]:
        """The list of texts that a text holds as JSON. Raises ArrayFileError."""
        try:
            values = json.loads(self[name])
        except (TypeError, ValueError, RecursionError):
            values = None
        if not isinstance(values, list) or not all(isinstance(v, str) for v in values):
            raise ArrayFileError(f"{self._path}: its text {name!r} is no list of texts; {REMEDY}")
        return values


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
        Numbers or booleans, together at most MAX_BYTES.
    metadata : mapping of str to str
        For example the provenance of the arrays.

    Raises
    ------
    ArrayFileError
        If the arrays are too large to be read again.
    """
    total = sum(np.asarray(array).nbytes for array in arrays.values())
    if total > MAX_BYTES:
        raise ArrayFileError(
            f"{path}: arrays of {total:,} bytes, and at most {MAX_BYTES:,} are read again; "
            "cut the work into smaller jobs"
        )
    buffer = io.BytesIO()  # on a full disk, HDF5 itself raises long and unclear errors
    with h5py.File(buffer, "w", userblock_size=USER_BLOCK) as file:
        for name, array in arrays.items():
            chunks = (1, *array.shape[1:]) if array.ndim > 2 and array.size else None
            file.create_dataset(
                name,
                data=array,
                chunks=chunks,
                compression="lzf" if chunks else None,
                track_times=False,
            )
        digest = _hash(arrays, metadata)
        file.attrs.update(format=FORMAT, content=content, sha256=digest, **metadata)
    rest = buffer.getbuffer()[USER_BLOCK:]
    header = f"sensory-commutativity arrays; sha256 of the rest: {_file_hash(rest)}\n".encode()
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        file.write(header.ljust(USER_BLOCK, b"\0"))
        file.write(rest)


def read_arrays(
    path: Path, content: str | None, remedy: str = REMEDY
) -> tuple[StoredArrays, StoredTexts]:
    """Read the arrays and the metadata that :func:`write_arrays` wrote.

    Raises ArrayFileError if the file is missing, damaged, too large, of another version, holds
    anything but arrays, or is of another `content`; None accepts every content.
    """
    with _open(path, content, remedy) as file:
        arrays = {name: dataset[()] for name, dataset in file.items()}
        metadata, digest = _metadata(file), file.attrs.get("sha256")
        if _hash(arrays, metadata) != digest:
            raise ArrayFileError(f"{path}: damaged, its content does not match its hash; {remedy}")
    return StoredArrays(path, arrays), StoredTexts(path, metadata)


def read_array_metadata(path: Path, content: str | None, remedy: str = REMEDY) -> dict[str, str]:
    """Read the metadata alone; raises ArrayFileError as above.

    The hash of the whole file is checked, except in files of the earlier version.
    """
    with _open(path, content, remedy) as file:
        return _metadata(file)


@contextmanager
def _open(path: Path, content: str | None, remedy: str) -> Iterator[h5py.File]:
    """Open a file of this content, after all that can be checked before its arrays are read."""
    if not path.exists():
        raise ArrayFileError(f"{path}: there is no such file; run the workflow again")
    check_regular_file(path, ArrayFileError, remedy, MAX_BYTES)
    try:
        has_hash = _check_file_hash(path, remedy)
        with h5py.File(path, "r") as file:
            version = FORMAT if has_hash else UNBLOCKED_FORMAT
            if file.attrs.get("format") != version or (
                content is not None and file.attrs.get("content") != content
            ):
                raise ArrayFileError(
                    f"{path}: no file of {content or 'arrays'}, or of another version; {remedy}"
                )
            problem = _find_problem(file)
            if problem:
                raise ArrayFileError(f"{path}: {printable(problem)}; {remedy}")
            yield file
    except (OSError, KeyError, ValueError, RuntimeError, TypeError, MemoryError) as error:
        reason = printable((str(error).splitlines() or ["?"])[0])[:80]
        raise ArrayFileError(f"{path}: incomplete or damaged ({reason}); {remedy}") from None


def _check_file_hash(path: Path, remedy: str) -> bool:
    """Compare the file with the hash in its user block; False if it has no user block."""
    with path.open("rb") as file:
        header = file.read(USER_BLOCK)
        if header.startswith(b"\x89HDF"):
            return False
        match = _HEADER.fullmatch(header)
        if match is None:
            raise ArrayFileError(
                f"{path}: incomplete or damaged, or no file of arrays of this package; {remedy}"
            )
        digest = hashlib.sha256()
        while block := file.read(1 << 20):
            digest.update(block)
    if digest.hexdigest() != match[1].decode():
        raise ArrayFileError(f"{path}: damaged, its content does not match its hash; {remedy}")
    return True


def _find_problem(file: h5py.File) -> str:
    """What makes a file unsafe or impossible to read, or "". No array is read."""
    if len(file.attrs) > MAX_TEXTS or len(file) > MAX_ARRAYS:
        return f"has {len(file)} arrays and {len(file.attrs)} texts, more than a file may have"
    for key in file.attrs:
        attribute = file.attrs.get_id(key)
        if attribute.shape != () or attribute.get_storage_size() > MAX_TEXT_BYTES:
            return f"its metadata {key!r} is no single text"
        if not isinstance(file.attrs[key], str | np.integer):
            return f"its metadata {key!r} is no text"
    total = 0
    for name in file:
        if not isinstance(file.get(name, getlink=True), h5py.HardLink):
            return f"{name!r} is a link to elsewhere"
        dataset = file[name]
        problem = _find_array_problem(dataset)
        if problem:
            return f"{name!r} {problem}"
        total += dataset.nbytes
        if total > MAX_BYTES:
            return f"declares arrays of {total:,} bytes, and at most {MAX_BYTES:,} are read"
    return ""


def _find_array_problem(dataset: Any) -> str:
    if not isinstance(dataset, h5py.Dataset):
        return "is a group, not an array"
    if dataset.shape is None or dataset.dtype.kind not in "biuf" or dataset.dtype.metadata:
        return f"is no array of numbers, but {dataset.dtype}"
    if dataset.external or dataset.is_virtual:
        return "lies in another file"
    stored = dataset.id.get_storage_size()
    if dataset.ndim <= 2 or not dataset.size:
        complete = dataset.chunks is None and stored == dataset.nbytes
        return "" if complete or not dataset.size else "is not stored in one piece"
    plist = dataset.id.get_create_plist()
    filters = [plist.get_filter(i)[0] for i in range(plist.get_nfilters())]
    if dataset.chunks != (1, *dataset.shape[1:]) or filters != [h5py.h5z.FILTER_LZF]:
        return "is not stored in chunks of one row, compressed by LZF"
    if dataset.id.get_num_chunks() != len(dataset) or dataset.nbytes > MAX_RATIO * stored + 4096:
        return f"declares {dataset.nbytes:,} bytes, which {stored:,} bytes cannot hold"
    return ""


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


def _file_hash(data: bytes | memoryview) -> str:
    return hashlib.sha256(data).hexdigest()
