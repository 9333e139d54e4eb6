"""Checksums of the files of a finished run, in the format of ``sha256sum``.

The file begins with comments that say which configuration, seed and code its files come from.
"""

from __future__ import annotations

import re
import time
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from ..errors import UserError
from ..storage.atomic import atomic_write
from ..storage.files import printable, read_bounded
from ..storage.hashing import sha256
from .entries import FOLDERS, SUFFIXES, list_files, list_irregular

MANIFEST = "checksums.sha256"
MAX_BYTES = 50_000_000
"""Size of a file of checksums; chosen: half a million files."""
GROUPS = ("profile", "root_seed", "config_sha256", "git_commit")
"""Keys of the provenance by which files belong together."""

_LINE = re.compile(r"(\\?)([0-9a-f]{64}) [ *](\S.*)")
_COMMENT = re.compile(r"# (\w+) (\S+)")
_ESCAPES = {"\\": "\\\\", "\n": "\\n", "\r": "\\r"}
"""Characters of file names, as ``sha256sum`` writes them."""


class Manifest(NamedTuple):
    """Content of a file of checksums.

    Attributes
    ----------
    hashes : dict of str to str
        Path relative to the run's folder, with slashes -> SHA-256, hexadecimal.
    invalid_lines : tuple of int
        Numbers, from 1, of lines that are not the checksum of a result in the run's folder.
    groups : dict of str to tuple of str
        Key of GROUPS -> all its values among the files.
    """

    hashes: dict[str, str]
    invalid_lines: tuple[int, ...]
    groups: dict[str, tuple[str, ...]]


def read_manifest(path: Path) -> Manifest:
    """Read a file of checksums; if there is no such file, it has no lines. Raises UserError."""
    try:
        data = read_bounded(path, UserError, "run the workflow again", MAX_BYTES)
    except FileNotFoundError:
        return Manifest({}, (), {})
    except OSError as error:
        raise UserError(
            f"{path}: cannot be read ({error.strerror}); check its permissions"
        ) from None
    lines = data.decode("utf-8", "surrogateescape").split("\n")
    hashes: dict[str, str] = {}
    invalid: list[int] = []
    groups: dict[str, tuple[str, ...]] = {}
    for number, line in enumerate(lines, start=1):
        match, comment = _LINE.fullmatch(line), _COMMENT.fullmatch(line)
        if match:
            name = _unescape(match[3]) if match[1] else match[3]
            if name in hashes or not _is_result_name(name):
                invalid.append(number)
            else:
                hashes[name] = match[2]
        elif comment and comment[1] in GROUPS:
            groups[comment[1]] = (*groups.get(comment[1], ()), comment[2])
        elif not line.startswith("#") and (line or number < len(lines)):  # the last line is empty
            invalid.append(number)
    return Manifest(hashes, tuple(invalid), groups)


def _is_result_name(name: str) -> bool:
    path = PurePosixPath(name)
    hidden = any(part.startswith(".") for part in path.parts)
    return path.parts[0] in FOLDERS and path.suffix in SUFFIXES and not hidden


def _escape(name: str) -> str:
    return "".join(_ESCAPES.get(letter, letter) for letter in name)


def _unescape(name: str) -> str:
    letters = {escaped[1]: letter for letter, escaped in _ESCAPES.items()}
    return re.sub(r"\\(.)", lambda match: letters.get(match[1], match[0]), name)


def write_manifest(path: Path) -> tuple[int, int]:
    """Write the checksums of all files of a run.

    A file that does not have its old checksum, and is damaged by what it says of itself, keeps the
    old one: damage that has occurred since must not count as the result of the run. Types of files
    without a hash of their own keep it unless they were written after the checksums.

    Parameters
    ----------
    path : Path
        The file of checksums, in the folder of the run.

    Returns
    -------
    computed, kept : int
        Numbers of checksums that are new, and that are as before.

    Raises
    ------
    UserError
        If the folder holds no results, holds links, or a file cannot be read.
    """
    run = path.parent
    irregular = list_irregular(run)
    if irregular:
        name, kind = next(iter(irregular.items()))
        raise UserError(
            f"{run / printable(name)}: is {kind}, not a file of the run; put a file in its place"
        )
    old_hashes = read_manifest(path).hashes
    manifest_time = path.stat().st_mtime_ns if old_hashes else 0
    lines, kept, groups = [], 0, {key: set[str]() for key in GROUPS}
    for name in list_files(run):
        try:
            digest = sha256(run / name)
            old = old_hashes.get(name, digest)
            if old != digest and not was_recomputed(run / name, manifest_time):
                digest = old
        except OSError as error:
            raise UserError(
                f"{run / name}: cannot be read ({error.strerror}); "
                "delete it and run the workflow again"
            ) from None
        kept += old_hashes.get(name) == digest
        escaped = _escape(name)
        mark = "" if escaped == name else "\\"
        lines.append(f"{mark}{digest}  {escaped}\n")
        _add_origin(run / name, groups)
    if not lines:
        raise UserError(
            f"{run}: not a run, it has no files in {', '.join(FOLDERS)}; "
            f"give a path like results/default/{MANIFEST}"
        )
    with atomic_write(path) as temporary:
        text = "".join([*_describe_groups(groups), *lines])
        temporary.write_bytes(text.encode("utf-8", "surrogateescape"))
    return len(lines) - kept, kept


def was_recomputed(path: Path, manifest_time: int) -> bool:
    """Whether a file that has not its checksum was made again, rather than damaged.

    Its own hash decides, since clocks may be wrong. Without one it must have been written after the
    checksums, unless their time is in the future and says nothing.
    """
    from .verify import carries_hash, find_damage

    if find_damage(path) != "":
        return False
    newer = path.stat().st_mtime_ns > manifest_time or manifest_time > time.time_ns()
    return newer or carries_hash(path)


def _add_origin(path: Path, groups: dict[str, set[str]]) -> None:
    from .origin import read_own_origin

    try:
        origin = read_own_origin(path)
    except UserError:
        return
    for key, values in groups.items():
        if re.fullmatch(r"\S{1,200}", origin.get(key, "")) and origin[key].isprintable():
            values.add(origin[key])


def _describe_groups(groups: dict[str, set[str]]) -> list[str]:
    return [f"# {key} {value}\n" for key, values in groups.items() for value in sorted(values)]
