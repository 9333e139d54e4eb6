"""The checksums of a finished run, in a file that ``sha256sum -c`` reads too: what each file was when the run ended."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from ..errors import UserError
from ..storage.atomic import atomic_write

MANIFEST = "checksums.sha256"
FOLDERS = ("data", "models", "tables", "figures")
"""Folders of a run that hold what it made; not its logs, benchmarks and report, which are never twice the same."""
SUFFIXES = (".parquet", ".h5", ".json", ".predictor", ".policy", ".png", ".pdf", ".gif")

_LINE = re.compile(r"([0-9a-f]{64}) [ *](\S.*)")


class Manifest(NamedTuple):
    """What a file of checksums says.

    Attributes
    ----------
    hashes : dict of str to str
        Path, relative to the run's folder and with slashes -> SHA-256, hexadecimal.
    wrong : tuple of int
        Lines, from 1, that are no checksum of a file in the run's folder.
    """

    hashes: dict[str, str]
    wrong: tuple[int, ...]


def files_of(run: Path) -> list[str]:
    """What a run made, but for hidden files: paths relative to its folder, with slashes, sorted."""
    found = (
        path
        for folder in FOLDERS
        for path in (run / folder).rglob("*")
        if path.suffix in SUFFIXES and path.is_file()
    )
    paths = (path.relative_to(run) for path in found)
    return sorted(
        path.as_posix() for path in paths if not any(part.startswith(".") for part in path.parts)
    )


def sha256(path: Path) -> str:
    """SHA-256 of a file, hexadecimal. Raises OSError."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_manifest(path: Path) -> Manifest:
    """Read a file of checksums; one that is not there says nothing. Raises OSError."""
    try:
        lines = path.read_bytes().decode("utf-8", "replace").split("\n")
    except FileNotFoundError:
        return Manifest({}, ())
    hashes, wrong = {}, []
    for i, line in enumerate(lines):
        found = _LINE.fullmatch(line)
        if (
            found
            and not PurePosixPath(found[2]).is_absolute()
            and ".." not in PurePosixPath(found[2]).parts
        ):
            hashes[found[2]] = found[1]
        elif line or i < len(lines) - 1:
            wrong.append(i + 1)
    return Manifest(hashes, tuple(wrong))


def write_manifest(path: Path) -> tuple[int, int]:
    """Write the checksums of all files of the run in whose folder `path` lies; return how many were made, and how many kept.

    A file that was there when the checksums were last written, and was not written since, keeps its checksum: damage that came in between must not be
    taken for what the run made. Raises UserError where a file cannot be read.
    """
    run, old = path.parent, read_manifest(path).hashes
    written = path.stat().st_mtime_ns if old else 0
    lines, kept = [], 0
    for name in files_of(run):
        try:
            keep = name in old and (run / name).stat().st_mtime_ns < written
            lines.append(f"{old[name] if keep else sha256(run / name)}  {name}\n")
        except OSError as error:
            raise UserError(
                f"{run / name}: cannot be read ({error.strerror}); delete it and run the workflow again"
            ) from None
        kept += keep
    if not lines:
        raise UserError(
            f"{run}: no run, it holds no files in {', '.join(FOLDERS)}; give a path like results/default/{MANIFEST}"
        )
    with atomic_write(path) as temporary:
        temporary.write_text("".join(lines), encoding="utf-8")
    return len(lines) - kept, kept
