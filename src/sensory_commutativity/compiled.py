"""Compilation with numba, with a cache on disk.

numba recompiles a function when its own file changes, but not when the file of a function that was
compiled into it does. The cache folder is therefore named after the sources of all worlds: a change
to any of them compiles everything once more. The folder is set for the whole process, unless
NUMBA_CACHE_DIR is.
"""

from __future__ import annotations

import hashlib
import os
from functools import partial
from pathlib import Path

import numba

from .storage.folders import cache_folder


def _cache_folder() -> Path:
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted((Path(__file__).parent / "worlds").rglob("*.py")):
        digest.update(source.read_bytes())
    return cache_folder("numba", digest.hexdigest()[:16])


if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = str(_cache_folder())  # type: ignore[attr-defined]  # set dynamically

njit = partial(numba.njit, cache=True)
"""``numba.njit`` that keeps its result between processes; use as ``@njit()``."""
