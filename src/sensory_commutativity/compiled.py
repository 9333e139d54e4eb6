"""Compilation with numba, with a cache on disk.

numba recompiles a function when its own file changes, but not when the file of a function that was
compiled into it does. The cache folder is therefore named after the sources of all worlds: a change
to any of them compiles everything once more. The folder is set for the whole process, unless
NUMBA_CACHE_DIR is.

numba also runs whatever machine code it finds there. Here every file of the cache ends with the
hash of what is before it, and a function whose files are damaged is compiled again.
"""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile

from .storage.folders import cache_folder

_HASH_BYTES = 32


def _cache_folder() -> Path:
    digest = hashlib.sha256(numba.__version__.encode())
    digest.update(Path(__file__).read_bytes())
    for source in sorted((Path(__file__).parent / "worlds").rglob("*.py")):
        digest.update(source.read_bytes())
    return cache_folder("numba", digest.hexdigest()[:16])


if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = str(_cache_folder())  # type: ignore[attr-defined]  # set dynamically


class HashedCacheFile(IndexDataCacheFile):
    """The files of a compiled function, with a hash that numba, which reads until the end of what
    it wrote, does not see."""

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
        with super()._open_for_write(filepath) as file:
            content = io.BytesIO()
            yield content
            file.write(content.getvalue() + _hash(filepath, content.getvalue()))

    def _load_index(self) -> dict[Any, str]:
        """The names of the files of compiled code; none if the index is damaged."""
        return super()._load_index() if _is_intact(self._index_path) else {}

    def _load_data(self, name: str) -> Any:
        """Compiled code. Raises OSError if it is damaged, which numba takes for a missing file."""
        if not _is_intact(self._data_path(name)):
            raise OSError(f"{name}: damaged")
        return super()._load_data(name)


class HashedCache(FunctionCache):
    """numba's cache of a function, in files of :class:`HashedCacheFile`."""

    def __init__(self, function: Callable[..., Any]):
        super().__init__(function)
        self._cache_file = HashedCacheFile(
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base,
            source_stamp=self._impl.locator.get_source_stamp(),
        )


def _is_intact(path: str) -> bool:
    try:
        content = Path(path).read_bytes()
    except OSError:
        return False
    return _hash(path, content[:-_HASH_BYTES]) == content[-_HASH_BYTES:]


def _hash(path: str, content: bytes) -> bytes:
    """Hash of a file's content and name, since two files of a function may be exchanged."""
    return hashlib.sha256(f"{Path(path).name}\n".encode() + content).digest()


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """``numba.njit`` that keeps its result between processes; use as ``@njit()``."""

    def decorate(function: Callable[..., Any]) -> Any:
        compiled = numba.njit(**options)(function)
        if compiled is not function:  # as it is where numba is disabled
            compiled._cache = HashedCache(function)
        return compiled

    return decorate
