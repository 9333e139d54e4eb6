"""Can results be written where they should go? Asked before any work is done."""

from __future__ import annotations

import tempfile
from pathlib import Path

from .errors import ConfigError


def check_writable(folder: Path) -> None:
    """Raise ConfigError when `folder` cannot be made or written to; leaves nothing behind."""
    existing = folder
    while not existing.exists():
        existing = existing.parent
    remedy = "set the key 'results' to a folder that you may write to"
    if not existing.is_dir():
        raise ConfigError(f"{existing}: is a file, so results cannot go to {folder}; {remedy}")
    try:
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        raise ConfigError(f"{existing}: cannot be written to ({error.strerror}), so results cannot go to {folder}; {remedy}") from None
