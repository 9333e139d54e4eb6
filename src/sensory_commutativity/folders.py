"""Where files go: can results be written where they should (asked before any work is done), and where is kept what is made or fetched once?"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from .errors import ConfigError


def check_writable(folder: Path) -> None:
    """Raise ConfigError when `folder` cannot be made or written to; leaves nothing behind."""
    remedy = "set the key 'results' to a folder that you may write to"
    try:
        existing = next(path for path in (folder, *folder.parents) if path.exists())
        if not existing.is_dir():
            raise ConfigError(f"{existing}: is a file, so results cannot go to {folder}; {remedy}")
        inner = [path for path in existing.iterdir() if path.is_dir()] if existing == folder else []
        for place in (existing, *inner):
            with tempfile.TemporaryFile(dir=place):
                pass
    except OSError as error:
        where = error.filename or folder
        raise ConfigError(f"{where}: cannot be written to ({error.strerror}), so results cannot go to {folder}; {remedy}") from None


def cache_folder(*below: str) -> Path:
    """Where files are kept between runs: below XDG_CACHE_HOME, ~/.cache or, where neither can be written to, the user's own temporary folder."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    if not os.access(next(path for path in (base, *base.parents) if path.exists()), os.W_OK):
        base = Path(tempfile.gettempdir()) / f"cache-{os.getuid()}"
    return base.joinpath("sensory-commutativity", *below)
