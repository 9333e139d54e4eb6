"""Is a run as it was made? Files are held against the checksums of the run or, where it has none yet, read from end to end."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from ..errors import UserError
from .checksums import FOLDERS, MANIFEST, files_of, read_manifest, sha256


class Bad(NamedTuple):
    """A file that is not as it should be.

    Attributes
    ----------
    path : str
        Relative to the run's folder.
    verdict : str
        ``damaged``, ``missing``, or ``changed``: it can be read, is not what the checksums say, and was written after them.
    why : str
        What is wrong, in words.
    """

    path: str
    verdict: str
    why: str


class Verified(NamedTuple):
    """What was found.

    Attributes
    ----------
    bad : tuple of Bad
    recorded, read, unknown : int
        Files that are as the checksums say; those without a checksum that can be read; those without one that nothing here can read.
    absent : dict of str to int
        Folders that a published run leaves out -> how many files the checksums name in it.
    """

    bad: tuple[Bad, ...]
    recorded: int
    read: int
    unknown: int
    absent: dict[str, int]


def verify_run(run: Path) -> Verified:
    """Check every file of a run. Raises UserError for a folder that is none."""
    if not (run / MANIFEST).is_file() and not files_of(run):
        raise UserError(
            f"{run}: no run, it holds neither {MANIFEST} nor files in {', '.join(FOLDERS)}; give a folder like results/default"
        )
    manifest = read_manifest(run / MANIFEST)
    written = (run / MANIFEST).stat().st_mtime_ns if manifest.hashes else 0
    bad = [
        Bad(MANIFEST, "damaged", f"line {line} is no checksum of a file of this run")
        for line in manifest.wrong
    ]
    absent: Counter[str] = Counter()
    recorded = read = unknown = 0
    for name, expected in manifest.hashes.items():
        path = run / name
        if not path.is_file():
            folder = _left_out(run, name)
            if folder:
                absent[folder] += 1
            else:
                bad.append(Bad(name, "missing", "the checksums name it, but it is not there"))
            continue
        try:
            same = sha256(path) == expected
        except OSError as error:
            bad.append(Bad(name, "damaged", f"cannot be read ({error.strerror})"))
            continue
        if same:
            recorded += 1
        elif path.stat().st_mtime_ns > written and whole(path) == "":
            bad.append(Bad(name, "changed", "not what the checksums say, but written after them"))
        else:
            bad.append(Bad(name, "damaged", "not what the checksums say"))
    for name in files_of(run):
        if name not in manifest.hashes:
            wrong = whole(run / name)
            read += wrong == ""
            unknown += wrong is None
            bad += [Bad(name, "damaged", wrong)] if wrong else []
    return Verified(tuple(bad), recorded, read, unknown, dict(absent))


def remove_bad(run: Path, found: Verified) -> list[str]:
    """Delete what is bad, and the checksums, without which the workflow makes anew all that is missing; return the paths that were deleted.

    Raises UserError, and deletes nothing, where the raw data are not there: the workflow would make the whole run anew.
    """
    if not found.bad:
        return []
    if "data" in found.absent:
        raise UserError(
            f"{run / 'data'}: not here, so the workflow would make the whole run anew; take the bad files from where the run comes from"
        )
    names = [bad.path for bad in found.bad if bad.verdict != "missing" and bad.path != MANIFEST]
    names += (
        [MANIFEST] if (run / MANIFEST).exists() else []
    )  # last: if this is cut short, the rest is still known to be missing
    for name in names:
        (run / name).unlink(missing_ok=True)
    return names


def whole(path: Path) -> str | None:
    """What is wrong with a file that should be readable from end to end: an empty text for nothing; None where nothing here reads such files."""
    check = CHECKS.get(path.suffix)
    try:
        return check(path) if check else None
    except UserError as error:
        return str(error).removeprefix(f"{path}: ")
    except Exception as error:  # whatever the bytes lead the readers to
        return f"cannot be read ({(str(error).splitlines() or ['?'])[0][:80]})"


def _left_out(run: Path, name: str) -> str:
    """The folder, not there, with which a published run leaves this file out: its raw data, or models of one kind; empty for any other file."""
    parts = name.split("/")
    folder = parts[0] if parts[0] == "data" else "/".join(parts[:2]) if parts[0] == "models" else ""
    return folder if folder and not (run / folder).exists() else ""


def _table(path: Path) -> str | None:
    from ..storage.tables import TABLES, read_about, read_table

    name = read_about(path).get("table", "")  # not the file's name: raw data are parts of a table
    if name not in TABLES:
        return None
    read_table(name, path)
    return ""


def _arrays(path: Path) -> str | None:
    import h5py

    from ..storage.arrays import read_arrays

    with h5py.File(path, "r") as file:
        content = file.attrs.get("content")
    if content is None:
        return None
    read_arrays(path, content)
    return ""


def _model(path: Path) -> str:
    from ..storage.checkpoints import load_state

    load_state(path, "run the workflow again")
    return ""


def _picture(path: Path) -> str:
    from PIL import Image, ImageSequence

    with Image.open(path) as picture:
        picture.verify()
    with Image.open(path) as picture:
        for frame in ImageSequence.Iterator(picture):
            frame.load()
    return (
        "" if path.read_bytes().endswith(_LAST[path.suffix]) else "its end is missing"
    )  # which no reader needs


def _document(path: Path) -> str:
    data = path.read_bytes()
    return (
        ""
        if data.startswith(b"%PDF-") and data.endswith(_LAST[".pdf"])
        else "its beginning or its end is missing"
    )


def _json(path: Path) -> str:
    json.loads(path.read_bytes())
    return ""


_LAST = {".png": b"\x00\x00\x00\x00IEND\xaeB`\x82", ".gif": b"\x00;", ".pdf": b"%%EOF\n"}

CHECKS: dict[str, Callable[[Path], str | None]] = {
    ".parquet": _table,
    ".h5": _arrays,
    ".json": _json,
    ".predictor": _model,
    ".policy": _model,
    ".png": _picture,
    ".gif": _picture,
    ".pdf": _document,
}
"""How files that end so are read."""
