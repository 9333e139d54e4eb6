"""Can results be written where they should go? Asked before any work is done."""

from __future__ import annotations

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
