"""The files of a run's folder, without following links: they may lead anywhere."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from ..storage.files import describe_mode

FOLDERS = ("data", "models", "tables", "figures")
"""Folders of a run that hold its results. Logs, benchmarks and the report differ every time."""
SUFFIXES = (".parquet", ".h5", ".json", ".predictor", ".policy", ".png", ".pdf", ".gif")


def list_files(run: Path) -> list[str]:
    """List the results of a run without hidden files: relative paths with slashes, sorted."""
    return sorted(
        name
        for name, mode in _walk(run)
        if stat.S_ISREG(mode) and PurePosixPath(name).suffix in SUFFIXES
    )


def list_irregular(run: Path) -> dict[str, str]:
    """What lies where results should, and is no file: relative path -> "a link", "a pipe", ..."""
    found = {}
    for name, mode in _walk(run):
        is_result = PurePosixPath(name).suffix in SUFFIXES or stat.S_ISLNK(mode)
        if is_result and not stat.S_ISREG(mode):
            found[name] = describe_mode(mode)
    return dict(sorted(found.items()))


def is_result(run: Path, name: str) -> bool:
    """Whether `name` is the path of a result within the folder `run` that no link leads out of."""
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or path.parts[:1] not in [(f,) for f in FOLDERS]:
        return False
    return path.suffix in SUFFIXES and find_link(run, name) is None


def find_link(run: Path, name: str) -> str | None:
    """The first part of the path `name` below `run` that is a link, or None."""
    parts = PurePosixPath(name).parts
    for k in range(1, len(parts) + 1):
        part = "/".join(parts[:k])
        if (run / part).is_symlink():
            return part
    return None


def _walk(run: Path) -> Iterator[tuple[str, int]]:
    """Relative path and mode of everything in FOLDERS that is not hidden and no folder."""
    folders = list(FOLDERS)
    while folders:
        folder = folders.pop()
        try:
            mode = os.lstat(run / folder).st_mode
        except (FileNotFoundError, NotADirectoryError):
            continue
        if not stat.S_ISDIR(mode):
            yield folder, mode
            continue
        for name in os.listdir(run / folder):
            if not name.startswith("."):
                folders.append(f"{folder}/{name}")
