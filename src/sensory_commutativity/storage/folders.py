"""Where files go: can results be written where they should (asked before any work is done), by whom, and where what is made or fetched once?"""

from __future__ import annotations

import atexit
import fcntl
import os
import platform
import tempfile
from pathlib import Path

from ..errors import ConfigError


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
        raise ConfigError(
            f"{where}: cannot be written to ({error.strerror}), so results cannot go to {folder}; {remedy}"
        ) from None


def hold(folder: Path) -> None:
    """Keep `folder` for this process until it ends, however it ends. Raises ConfigError, naming the other, when another run holds it.

    Snakemake's own lock keeps two runs of one checkout apart; this one, two checkouts that share a results folder. The lock is the operating
    system's, so none is left behind by a run that was killed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / ".held"
    while True:
        file = path.open("a+", encoding="utf-8")  # kept open by the function that runs at the end
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            who = file.read().strip() or "another process"
            file.close()
            raise ConfigError(
                f"{folder}: {who} is writing results there; wait until it ends, or set another 'profile' or 'results'"
            ) from None
        except OSError:  # a file system without locks
            file.close()
            path.unlink(missing_ok=True)
            return
        if path.exists() and path.stat().st_ino == os.fstat(file.fileno()).st_ino:
            break
        file.close()  # whoever held it has just ended, and taken the file along
    file.truncate(0)
    file.write(f"process {os.getpid()} on {platform.node()}\n")
    file.flush()

    def release() -> None:
        path.unlink(missing_ok=True)
        file.close()

    atexit.register(release)


def cache_folder(*below: str) -> Path:
    """Where files are kept between runs: below XDG_CACHE_HOME, ~/.cache or, where neither can be written to, the user's own temporary folder."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    if not os.access(next(path for path in (base, *base.parents) if path.exists()), os.W_OK):
        base = Path(tempfile.gettempdir()) / f"cache-{os.getuid()}"
    return base.joinpath("sensory-commutativity", *below)
