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
from ..storage.hashing import sha256
from .checksums import FOLDERS, MANIFEST, list_files, read_manifest


class BadFile(NamedTuple):
    """A file that is not as it should be.

    Attributes
    ----------
    path : str
        Relative to the run's folder.
    status : str
        ``damaged``, ``missing``, or ``changed``: it is readable, does not have its checksum, and
        was written after the checksums.
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
    """Check every file of a run. Raises UserError for a folder that is not a run."""
    if not (run / MANIFEST).is_file() and not list_files(run):
        raise UserError(
            f"{run}: not a run, it has neither {MANIFEST} nor files in {', '.join(FOLDERS)}; "
            "give a folder like results/default"
        )
    manifest = read_manifest(run / MANIFEST)
    manifest_time = (run / MANIFEST).stat().st_mtime_ns if manifest.hashes else 0
    bad = [
        BadFile(MANIFEST, "damaged", f"line {line} is not the checksum of a file of this run")
        for line in manifest.invalid_lines
    ]
    absent: Counter[str] = Counter()
    recorded = readable = unchecked = 0
    for name, expected in manifest.hashes.items():
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
    except OSError as error:
        return BadFile(name, "damaged", f"cannot be read ({error.strerror})")
    if path.stat().st_mtime_ns > manifest_time and find_damage(path) == "":
        return BadFile(name, "changed", "does not have its checksum, but was written after it")
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

    Returns
    -------
    list of str
        Paths of the deleted files, relative to the run's folder.

    Raises
    ------
    UserError
        If the raw data are absent; nothing is deleted then, because the workflow would compute the
        whole run again.
    """
    if not verification.bad:
        return []
    if "data" in verification.absent:
        raise UserError(
            f"{run / 'data'}: absent, so the workflow would compute the whole run again; "
            "copy the bad files again from where the run comes from"
        )
    names = [
        bad.path for bad in verification.bad if bad.status != "missing" and bad.path != MANIFEST
    ]
    if (run / MANIFEST).exists():
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
        return check(path) if check else None
    except UserError as error:
        return str(error).removeprefix(f"{path}: ")
    except Exception as error:  # the bytes decide what the readers raise
        return f"cannot be read ({(str(error).splitlines() or ['?'])[0][:80]})"


def _check_table(path: Path) -> str | None:
    from ..storage.tables import read_metadata, read_table
    from ..studies.registry import find_table, table_names

    name = read_metadata(path).get("table", "")  # raw data are shards with other file names
    if name not in table_names():
        return None
    read_table(path, name, find_table(name).columns)
    return ""


def _check_arrays(path: Path) -> str | None:
    import h5py

    from ..storage.arrays import read_arrays

    with h5py.File(path, "r") as file:
        content = file.attrs.get("content")
    if content is None:
        return None
    read_arrays(path, content)
    return ""


def _check_model(path: Path) -> str:
    from ..storage.checkpoints import load_state

    load_state(path, "run the workflow again")
    return ""


def _check_image(path: Path) -> str:
    from PIL import Image, ImageSequence

    with Image.open(path) as image:
        image.verify()
    with Image.open(path) as image:
        for frame in ImageSequence.Iterator(image):
            frame.load()
    complete = path.read_bytes().endswith(_LAST_BYTES[path.suffix])  # no reader needs them
    return "" if complete else "its end is missing"


def _check_pdf(path: Path) -> str:
    data = path.read_bytes()
    complete = data.startswith(b"%PDF-") and data.endswith(_LAST_BYTES[".pdf"])
    return "" if complete else "its beginning or its end is missing"


def _check_json(path: Path) -> str:
    json.loads(path.read_bytes())
    return ""


_LAST_BYTES = {".png": b"\x00\x00\x00\x00IEND\xaeB`\x82", ".gif": b"\x00;", ".pdf": b"%%EOF\n"}

CHECKS: dict[str, Callable[[Path], str | None]] = {
    ".parquet": _check_table, ".h5": _check_arrays, ".json": _check_json,
    ".predictor": _check_model, ".policy": _check_model,
    ".png": _check_image, ".gif": _check_image, ".pdf": _check_pdf,
}  # fmt: skip
"""Suffix -> function that reads a whole file; see :func:`find_damage`."""
