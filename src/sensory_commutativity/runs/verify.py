"""Verification of a finished run: have its files changed since they were written?

Files are compared with the run's checksums. Files without one are read from beginning to end.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from ..errors import UserError
from ..storage.files import check_regular_file, printable, read_bounded
from ..storage.hashing import sha256
from ..storage.seal import is_intact
from .checksums import MANIFEST, read_manifest, was_recomputed
from .entries import FOLDERS, find_link, is_result, list_files, list_irregular

MAX_BYTES = 200_000_000
"""Size of a PDF or JSON file; chosen: a hundred times that of our largest."""


class BadFile(NamedTuple):
    """A file that is not as it should be.

    Attributes
    ----------
    path : str
        Relative to the run's folder.
    status : str
        ``damaged``, ``missing``, ``irregular``: it is a link or no file, or ``changed``: it is
        whole, does not have its checksum, and was made after the checksums.
    reason : str
        What is wrong, in words.
    """

    path: str
    status: str
    reason: str


class Verification(NamedTuple):
    """Result of :func:`verify_run`.

    Attributes
    ----------
    bad : tuple of BadFile
    recorded, readable, unchecked : int
        Numbers of files that have their checksum; that have none and are readable; that have none
        and are of a type that cannot be checked.
    absent : dict of str to int
        Folders that a published run omits -> number of their files among the checksums.
    """

    bad: tuple[BadFile, ...]
    recorded: int
    readable: int
    unchecked: int
    absent: dict[str, int]


def verify_run(run: Path) -> Verification:
    """Check every file of a run; no link is followed. Raises UserError if it is no run."""
    irregular = list_irregular(run)
    if not (run / MANIFEST).exists() and not list_files(run) and not irregular:
        raise UserError(
            f"{run}: not a run, it has neither {MANIFEST} nor files in {', '.join(FOLDERS)}; "
            "give a folder like results/default"
        )
    bad = [
        BadFile(name, "irregular", f"is {kind}, not a file of the run")
        for name, kind in irregular.items()
    ]
    if (run / MANIFEST).is_symlink():
        bad.append(BadFile(MANIFEST, "irregular", "is a link, not a file of the run"))
        return Verification(tuple(bad), 0, 0, 0, {})
    manifest = read_manifest(run / MANIFEST)
    manifest_time = (run / MANIFEST).stat().st_mtime_ns if manifest.hashes else 0
    bad += [
        BadFile(MANIFEST, "damaged", f"line {line} is not the checksum of a file of this run")
        for line in manifest.invalid_lines
    ]
    absent: Counter[str] = Counter()
    recorded = readable = unchecked = 0
    for name, expected in manifest.hashes.items():
        if name in irregular or find_link(run, name) in irregular:
            continue
        folder = _omitted_folder(run, name)
        if folder:
            absent[folder] += 1
            continue
        bad_file = _compare_with_checksum(run, name, expected, manifest_time)
        if bad_file is None:
            recorded += 1
        else:
            bad.append(bad_file)
    for name in list_files(run):
        if name not in manifest.hashes:
            damage = find_damage(run / name)
            if damage:
                bad.append(BadFile(name, "damaged", damage))
            readable += damage == ""
            unchecked += damage is None
    return Verification(tuple(bad), recorded, readable, unchecked, dict(absent))


def _compare_with_checksum(
    run: Path, name: str, expected: str, manifest_time: int
) -> BadFile | None:
    path = run / name
    if not path.is_file():
        return BadFile(name, "missing", "it has a checksum, but does not exist")
    try:
        if sha256(path) == expected:
            return None
        if was_recomputed(path, manifest_time):
            return BadFile(name, "changed", "does not have its checksum, but is whole: recomputed")
    except OSError as error:
        return BadFile(name, "damaged", f"cannot be read ({error.strerror})")
    return BadFile(name, "damaged", "does not have its checksum")


def _omitted_folder(run: Path, name: str) -> str:
    """The folder that is absent with a missing file because published runs omit it, or "".

    That is the raw data, or all models of one kind.
    """
    parts = name.split("/")
    folder = {"data": "data", "models": "/".join(parts[:2])}.get(parts[0], "")
    return folder if folder and not (run / folder).exists() else ""


def remove_bad_files(run: Path, verification: Verification) -> list[str]:
    """Delete the bad files and the checksums, so that the workflow computes all that is missing.

    Only results within the folder of the run are deleted, never links or what they lead to.

    Returns
    -------
    list of str
        Paths of the deleted files, relative to the run's folder.

    Raises
    ------
    UserError
        If the raw data are absent, or if the run holds links; nothing is deleted then: in the first
        case the workflow would compute the whole run again.
    """
    if not verification.bad:
        return []
    if "data" in verification.absent:
        raise UserError(
            f"{run / 'data'}: absent, so the workflow would compute the whole run again; "
            "copy the bad files again from where the run comes from"
        )
    for bad in verification.bad:
        if bad.status == "irregular":
            raise UserError(
                f"{run / printable(bad.path)}: {bad.reason}, so nothing is deleted; "
                "put what it stands for in its place, or delete it"
            )
    names = [
        bad.path
        for bad in verification.bad
        if bad.status in ("damaged", "changed") and is_result(run, bad.path)
    ]
    if (run / MANIFEST).is_file() and not (run / MANIFEST).is_symlink():
        names.append(MANIFEST)  # last: if interrupted, the other files are still known as missing
    for name in names:
        (run / name).unlink(missing_ok=True)
    return names


def find_damage(path: Path) -> str | None:
    """Read a file from beginning to end.

    Returns
    -------
    str or None
        What is wrong, "" if nothing is; None if files of this type cannot be checked.
    """
    check = CHECKS.get(path.suffix)
    try:
        check_regular_file(path, UserError, "give a file of a run")
        return check(path) if check else None
    except UserError as error:
        return str(error).removeprefix(f"{path}: ")
    except Exception as error:  # the bytes decide what the readers raise
        return f"cannot be read ({printable((str(error).splitlines() or ['?'])[0])[:80]})"


def carries_hash(path: Path) -> bool:
    """Whether a readable file carries a hash of its content."""
    if path.suffix in (".parquet", ".pdf", ".gif", ".json"):
        return is_intact(path.read_bytes()) is not None
    return path.suffix in CHECKS


def _check_table(path: Path) -> str | None:
    from ..storage.tables import read_metadata, read_table
    from ..studies.registry import find_table, table_names

    name = read_metadata(path).get("table", "")  # raw data are shards with other file names
    if name not in table_names():
        return None
    read_table(path, name, find_table(name).columns, REMEDY, require_hash=False)
    return ""


def _check_arrays(path: Path) -> str | None:
    from ..storage.arrays import read_arrays

    read_arrays(path, None, REMEDY)
    return ""


def _check_model(path: Path) -> str:
    from ..storage.checkpoints import load_state

    load_state(path, "run the workflow again")
    return ""


def _check_image(path: Path) -> str:
    from ..storage.pictures import check_picture

    check_picture(path, REMEDY)
    data = path.read_bytes()
    if path.suffix == ".gif" and is_intact(data) is False:
        return SEAL_BROKEN
    complete = data.endswith(_LAST_BYTES[path.suffix])  # no reader needs them
    return "" if complete else "its end is missing"


def _check_pdf(path: Path) -> str:
    data = read_bounded(path, UserError, REMEDY, MAX_BYTES)
    if is_intact(data) is False:
        return SEAL_BROKEN
    complete = data.startswith(b"%PDF-") and data.endswith(_LAST_BYTES[".pdf"])
    return "" if complete else "its beginning or its end is missing"


def _check_json(path: Path) -> str:
    data = read_bounded(path, UserError, REMEDY, MAX_BYTES)
    json.loads(data)
    return SEAL_BROKEN if is_intact(data) is False else ""


REMEDY = "delete it and run the workflow again"
SEAL_BROKEN = "damaged, its content does not match its hash"
_LAST_BYTES = {".png": b"\x00\x00\x00\x00IEND\xaeB`\x82", ".gif": b"\x00;", ".pdf": b"%%EOF\n"}

CHECKS: dict[str, Callable[[Path], str | None]] = {
    ".parquet": _check_table, ".h5": _check_arrays, ".json": _check_json,
    ".predictor": _check_model, ".policy": _check_model,
    ".png": _check_image, ".gif": _check_image, ".pdf": _check_pdf,
}  # fmt: skip
"""Suffix -> function that reads a whole file; see :func:`find_damage`."""
