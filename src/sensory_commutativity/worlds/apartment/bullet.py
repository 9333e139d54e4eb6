"""PyBullet, imported without the line about its build that it prints."""

from __future__ import annotations

import os
import sys


def _import_quietly() -> None:
    sys.stderr.flush()
    kept = os.dup(2)
    silent = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(silent, 2)
        import pybullet  # noqa: F401
    finally:
        os.dup2(kept, 2)
        os.close(silent)
        os.close(kept)


_import_quietly()

import pybullet  # noqa: E402

__all__ = ["pybullet"]
