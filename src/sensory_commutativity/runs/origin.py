"""Provenance of the files of a run; see :mod:`.storage.provenance`.

Tables, array files, models, figures and animations carry it themselves, a report by its pictures.
For the other files (settings, checksums, logs) it is that of their run.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable
from pathlib import Path

from ..errors import UserError
from ..storage.files import check_regular_file, printable, read_bounded
from ..storage.hashing import sha256

FIRST_KEYS = (
    "table", "content", "profile", "config_sha256", "root_seed", "git_commit", "python",
    "platform", "packages",
)  # fmt: skip
"""Order in which keys are shown, before all others."""
MAX_BYTES = 200_000_000
"""Size of a PDF, JSON or HTML file; chosen: eight times that of our largest report."""
MAX_VALUE = 20_000
"""Characters of a value that is read; chosen: ten times our longest."""
REMEDY = "delete it and run the workflow again"


class OriginError(UserError):
    """A file carries no provenance."""


def read_origin(path: Path) -> dict[str, str]:
    """Read the provenance of a file of a run.

    Raises
    ------
    OriginError
        If the file is missing, damaged, or has none, and lies in no run. The readers of some files
        raise a UserError of their own.
    """
    if path.suffix in READERS:
        try:
            return read_own_origin(path)
        except NoOriginError:
            pass
    origin = _read_run_origin(path)
    if not path.exists():
        raise OriginError(
            f"{path}: there is no such file; "
            "give a table, an array file, a model or a figure of a run"
        )
    check_regular_file(path, OriginError, "give a file of a run")
    if origin is None:
        raise OriginError(
            f"{path}: carries no provenance, and lies in no run (a folder with config.yaml); "
            f"give a file of a run, or one of the types {', '.join(READERS)}"
        )
    return origin


class NoOriginError(OriginError):
    """A file can be read, and carries no provenance."""


def read_own_origin(path: Path) -> dict[str, str]:
    """Read the provenance that a file itself carries. Raises OriginError or another UserError."""
    if not path.exists():
        raise OriginError(
            f"{path}: there is no such file; "
            "give a table, an array file, a model or a figure of a run"
        )
    check_regular_file(path, OriginError, "give a file of a run")
    read = READERS.get(path.suffix)
    if read is None:
        raise NoOriginError(f"{path}: files of type {path.suffix or '(none)'} carry no provenance")
    try:
        origin = read(path)
    except UserError:
        raise
    except Exception as error:  # the bytes decide what the readers raise
        reason = printable((str(error).splitlines() or ["?"])[0])[:80]
        raise OriginError(f"{path}: cannot be read ({reason}); {REMEDY}") from None
    if "config_sha256" not in origin:
        raise NoOriginError(
            f"{path}: carries no provenance; it was not written by this version's workflow"
        )
    return _ordered(origin)


def _ordered(origin: dict[str, str]) -> dict[str, str]:
    keys = [key for key in FIRST_KEYS if key in origin]
    keys += [key for key in origin if key not in FIRST_KEYS]
    return {key: origin[key][:MAX_VALUE] for key in keys}


def _texts(value: object) -> dict[str, str]:
    """The texts of a JSON mapping; empty for anything else."""
    items = value.items() if isinstance(value, dict) else ()
    return {key: text for key, text in items if isinstance(key, str) and isinstance(text, str)}


def _read_run_origin(path: Path) -> dict[str, str] | None:
    """What the settings of the run that a file lies in say; None outside of a run."""
    from ..storage.yamlfile import read_yaml

    for folder in path.absolute().parents[:4]:
        settings = folder / "config.yaml"
        if settings.is_file() and settings.parent.name != "config":
            content = read_yaml(settings, OriginError, "the settings of a run")
            if not isinstance(content, dict) or "profile" not in content:
                return None
            origin = {"profile": str(content["profile"]), "root_seed": str(content.get("seed"))}
            origin["provenance_of"] = f"the run, by its settings {settings.name}"
            return _ordered({**origin, "config_sha256": _digest_of_settings(settings)})
    return None


def _digest_of_settings(path: Path) -> str:
    """SHA-256 of the settings as files record it; of the file if this version cannot read it."""
    from ..studies.loading import load

    try:
        return load(path).digest()
    except UserError:
        return f"unknown: settings of another version; of the file {sha256(path)}"


def _read_table(path: Path) -> dict[str, str]:
    from ..storage.tables import read_metadata

    return {key: value for key, value in read_metadata(path).items() if key != "pandas"}


def _read_arrays(path: Path) -> dict[str, str]:
    from ..storage.arrays import read_array_metadata

    return {key: str(value) for key, value in read_array_metadata(path, None).items()}


def _read_model(path: Path) -> dict[str, str]:
    from ..storage.checkpoints import load_state

    return _texts(load_state(path, "run the workflow again").get("about", {}))


def _read_image(path: Path) -> dict[str, str]:
    from ..storage.pictures import FORMATS, open_picture

    with open_picture(path, FORMATS[path.suffix], REMEDY) as image:
        if path.suffix == ".gif":
            comment = image.info.get("comment", b"{}")
            return _texts(json.loads(comment if isinstance(comment, bytes | str) else b"{}"))
        return _texts(image.info)


def _read_pdf(path: Path) -> dict[str, str]:
    data = read_bounded(path, OriginError, REMEDY, MAX_BYTES)
    start = data.find(b"/Keywords (")
    if start < 0:
        return {}
    keywords = re.match(rb"/Keywords \((.*?)(?<!\\)\)", data[start : start + MAX_VALUE], re.DOTALL)
    return _texts(json.loads(re.sub(rb"\\(.)", rb"\1", keywords[1]))) if keywords else {}


def _read_json(path: Path) -> dict[str, str]:
    content = json.loads(read_bounded(path, OriginError, REMEDY, MAX_BYTES))
    return _texts(content.get("about")) if isinstance(content, dict) else {}


def _read_report(path: Path) -> dict[str, str]:
    """The provenance of the pictures in a report; values that differ are joined."""
    from .report import read_pictures

    return merge_origins(_picture_origin(data) for data in read_pictures(path).values())


def _picture_origin(data: bytes) -> dict[str, str]:
    import io

    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=["PNG", "GIF"]) as image:
            comment = image.info.get("comment")
            return _texts(json.loads(comment) if comment else image.info)
    except Exception:  # the bytes decide what Pillow's readers raise
        return {}


def merge_origins(origins: Iterable[dict[str, str]]) -> dict[str, str]:
    """One provenance of several files: each key with all its values, in order, with commas."""
    values: dict[str, dict[str, None]] = {}
    for origin in origins:
        for key, value in origin.items():
            if key in FIRST_KEYS:
                values.setdefault(key, {})[value] = None
    packages = values.pop("packages", {})
    merged = {key: ", ".join(found) for key, found in values.items()}
    return merged | ({"packages": next(iter(packages))} if len(packages) == 1 else {})


def _read_manifest(path: Path) -> dict[str, str]:
    from .checksums import read_manifest

    groups = read_manifest(path).groups
    return {key: ", ".join(values) for key, values in groups.items()}


READERS: dict[str, Callable[[Path], dict[str, str]]] = {
    ".parquet": _read_table, ".h5": _read_arrays, ".predictor": _read_model,
    ".policy": _read_model, ".png": _read_image, ".gif": _read_image, ".pdf": _read_pdf,
    ".json": _read_json, ".html": _read_report, ".sha256": _read_manifest,
}  # fmt: skip
"""Suffix -> function that reads the provenance."""
