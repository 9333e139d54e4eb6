"""Checksums of the files of a finished run, in the format of ``sha256sum``."""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from ..errors import UserError
from ..storage.atomic import atomic_write
from ..storage.hashing import sha256

MANIFEST = "checksums.sha256"
FOLDERS = ("data", "models", "tables", "figures")
"""Folders of a run that hold its results. Logs, benchmarks and the report differ every time."""
SUFFIXES = (".parquet", ".h5", ".json", ".predictor", ".policy", ".png", ".pdf", ".gif")

_LINE = re.compile(r"([0-9a-f]{64}) [ *](\S.*)")


class Manifest(NamedTuple):
    """Content of a file of checksums.

    Attributes
    ----------
    hashes : dict of str to str
        Path relative to the run's folder, with slashes -> SHA-256, hexadecimal.
    invalid_lines : tuple of int
        Numbers, from 1, of lines that are not the checksum of a file in the run's folder.
    """

    hashes: dict[str, str]
    invalid_lines: tuple[int, ...]


def list_files(run: Path) -> list[str]:
    """List the results of a run without hidden files: relative paths with slashes, sorted."""
    paths = [
        path.relative_to(run)
        for folder in FOLDERS
        for path in (run / folder).rglob("*")
        if path.suffix in SUFFIXES and path.is_file()
    ]
    return sorted(
        path.as_posix() for path in paths if not any(part.startswith(".") for part in path.parts)
    )


def read_manifest(path: Path) -> Manifest:
    """Read a file of checksums; if there is no such file, it has no lines. Raises OSError."""
    try:
        lines = path.read_bytes().decode("utf-8", "replace").split("\n")
    except FileNotFoundError:
        return Manifest({}, ())
    hashes, invalid = {}, []
    for number, line in enumerate(lines, start=1):
        match = _LINE.fullmatch(line)
        if match and _is_inside(PurePosixPath(match[2])):
            hashes[match[2]] = match[1]
        elif line or number < len(lines):  # the last line is empty
            invalid.append(number)
    return Manifest(hashes, tuple(invalid))


def _is_inside(path: PurePosixPath) -> bool:
    return not path.is_absolute() and ".." not in path.parts


def write_manifest(path: Path) -> tuple[int, int]:
    """Write the checksums of all files of a run.

    A file that has a checksum and has not been modified since keeps it: damage that has occurred
    since must not count as the result of the run.

    Parameters
    ----------
    path : Path
        The file of checksums, in the folder of the run.

    Returns
    -------
    computed, kept : int
        Numbers of checksums.

    Raises
    ------
    UserError
        If the folder holds no results or a file cannot be read.
    """
    run = path.parent
    old_hashes = read_manifest(path).hashes
    manifest_time = path.stat().st_mtime_ns if old_hashes else 0
    lines, kept = [], 0
    for name in list_files(run):
        try:
            keep = name in old_hashes and (run / name).stat().st_mtime_ns < manifest_time
            lines.append(f"{old_hashes[name] if keep else sha256(run / name)}  {name}\n")
        except OSError as error:
            raise UserError(
                f"{run / name}: cannot be read ({error.strerror}); "
                "delete it and run the workflow again"
            ) from None
        kept += keep
    if not lines:
        raise UserError(
            f"{run}: not a run, it has no files in {', '.join(FOLDERS)}; "
            f"give a path like results/default/{MANIFEST}"
        )
    with atomic_write(path) as temporary:
        temporary.write_text("".join(lines), encoding="utf-8")
    return len(lines) - kept, kept
