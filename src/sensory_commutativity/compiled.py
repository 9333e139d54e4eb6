"""Compiling loops with numba, and keeping what was compiled.

numba notices when the file of a compiled function changes, but not when a file does whose functions were compiled into it. So the cache lies
in a folder named after all the package's sources: edit any of them and everything is compiled anew, once.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from functools import partial
from pathlib import Path

import numba


def _cache_folder() -> Path:
    package = Path(__file__).parent
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(package.rglob("*.py")):
        text = source.read_bytes()
        if b"njit" in text:
            digest.update(text)
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    if not os.access(base if base.exists() else base.parent, os.W_OK):
        base = Path(tempfile.gettempdir())
    return base / "sensory-commutativity" / "numba" / digest.hexdigest()[:16]


if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = str(_cache_folder())

njit = partial(numba.njit, cache=True)
"""``numba.njit`` that keeps its result between processes; use as ``@njit()``."""
