"""Provenance that tables, array files, models and figures carry; see :mod:`.storage.provenance`."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

from ..errors import UserError

FIRST_KEYS = (
    "table", "content", "profile", "config_sha256", "root_seed", "git_commit", "python",
    "platform", "packages",
)  # fmt: skip
"""Order in which keys are shown, before all others."""


class OriginError(UserError):
    """A file carries no provenance."""


def read_origin(path: Path) -> dict[str, str]:
    """Read the provenance of a file.

    Raises
    ------
    OriginError
        If the file is missing, damaged, or carries none. The readers of some files raise a
        UserError of their own.
    """
    if not path.is_file():
        raise OriginError(
            f"{path}: there is no such file; "
            "give a table, an array file, a model or a figure of a run"
        )
    read = READERS.get(path.suffix)
    if read is None:
        raise OriginError(
            f"{path}: files of type {path.suffix or '(none)'} carry no provenance; "
            f"give one of {', '.join(READERS)}"
        )
    try:
        origin = read(path)
    except UserError:
        raise
    except Exception as error:  # the bytes decide what the readers raise
        reason = (str(error).splitlines() or ["?"])[0][:80]
        raise OriginError(
            f"{path}: cannot be read ({reason}); delete it and run the workflow again"
        ) from None
    if "config_sha256" not in origin:
        raise OriginError(
            f"{path}: carries no provenance; it was not written by this version's workflow"
        )
    ordered = [key for key in FIRST_KEYS if key in origin]
    ordered += [key for key in origin if key not in FIRST_KEYS]
    return {key: origin[key] for key in ordered}


def _read_table(path: Path) -> dict[str, str]:
    from ..storage.tables import read_metadata

    return {key: value for key, value in read_metadata(path).items() if key != "pandas"}


def _read_arrays(path: Path) -> dict[str, str]:
    import h5py

    with h5py.File(path, "r") as file:
        return {key: str(value) for key, value in file.attrs.items()}


def _read_model(path: Path) -> dict[str, str]:
    from ..storage.checkpoints import load_state

    return dict(load_state(path, "run the workflow again").get("about", {}))


def _read_image(path: Path) -> dict[str, str]:
    from PIL import Image

    with Image.open(path) as image:
        if path.suffix == ".gif":
            return json.loads(image.info.get("comment", b"{}"))
        return {str(key): value for key, value in image.info.items() if isinstance(value, str)}


def _read_pdf(path: Path) -> dict[str, str]:
    keywords = re.search(rb"/Keywords \((.*?)(?<!\\)\)", path.read_bytes(), re.DOTALL)
    return json.loads(re.sub(rb"\\(.)", rb"\1", keywords[1])) if keywords else {}


READERS: dict[str, Callable[[Path], dict[str, str]]] = {
    ".parquet": _read_table, ".h5": _read_arrays, ".predictor": _read_model,
    ".policy": _read_model, ".png": _read_image, ".gif": _read_image, ".pdf": _read_pdf,
}  # fmt: skip
"""Suffix -> function that reads the provenance."""
