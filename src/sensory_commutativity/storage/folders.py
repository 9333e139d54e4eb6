"""Folders of results and of caches: checks that they are writable, and a lock."""

from __future__ import annotations

import atexit
import fcntl
import os
import platform
import tempfile
from pathlib import Path

from ..errors import UserError


def check_writable(
    folder: Path, remedy: str = "choose a folder in which you can create files"
) -> None:
    """Check that `folder` exists or can be created, and that files can be created in it.

    Nothing is left behind. Subfolders that exist are checked too: another user may have made them.

    Raises
    ------
    UserError
        With `remedy`.
    """
    try:
        existing = next(path for path in (folder, *folder.parents) if path.exists())
        if not existing.is_dir():
            raise UserError(f"{existing}: is a file, so results cannot go to {folder}; {remedy}")
        subfolders = [p for p in existing.iterdir() if p.is_dir()] if existing == folder else []
        for path in (existing, *subfolders):
            with tempfile.TemporaryFile(dir=path):
                pass
    except OSError as error:
        raise UserError(
            f"{error.filename or folder}: cannot be written to ({error.strerror}), "
            f"so results cannot go to {folder}; {remedy}"
        ) from None


def lock_folder(folder: Path, remedy: str = "wait until it ends, or choose another folder") -> None:
    """Lock `folder` for this process until it ends, in whatever way it ends.

    Snakemake's own lock keeps apart two runs of one checkout; this one keeps apart two checkouts
    that share a folder of results. The lock belongs to the operating system, so a killed process
    leaves none behind. File systems without locks are not locked.

    Raises
    ------
    UserError
        If another process has locked the folder; with its name and `remedy`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / ".lock"
    while True:
        file = path.open("a+", encoding="utf-8")  # stays open until release()
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            owner = file.read().strip() or "another process"
            file.close()
            raise UserError(f"{folder}: locked by {owner}, which writes there; {remedy}") from None
        except OSError:  # a file system without locks
            file.close()
            path.unlink(missing_ok=True)
            return
        if path.exists() and path.stat().st_ino == os.fstat(file.fileno()).st_ino:
            break
        file.close()  # its owner has just ended and deleted the file that we opened: try again
    file.truncate(0)
    file.write(f"process {os.getpid()} on {platform.node()}\n")
    file.flush()

    def release() -> None:
        path.unlink(missing_ok=True)
        file.close()

    atexit.register(release)


def cache_folder(*subfolders: str) -> Path:
    """Folder for files that are kept between runs: ``CACHE/sensory-commutativity/SUBFOLDERS``.

    CACHE is $XDG_CACHE_HOME, else ``~/.cache``, else, if that is not writable, a folder of the
    user's own in the temporary folder. The folder is not created.
    """
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    if not os.access(next(path for path in (base, *base.parents) if path.exists()), os.W_OK):
        base = Path(tempfile.gettempdir()) / f"cache-{os.getuid()}"
    return base.joinpath("sensory-commutativity", *subfolders)
