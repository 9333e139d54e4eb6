"""Where a file comes from: every table, array file, model and figure carries it (see :mod:`sensory_commutativity.provenance`)."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

from ..errors import UserError

FIRST = (
    "table",
    "content",
    "profile",
    "config_sha256",
    "root_seed",
    "git_commit",
    "python",
    "platform",
    "packages",
)
"""In which order keys are shown; all others follow."""


class OriginError(UserError):
    """A file says nothing of where it comes from."""


def origin_of(path: Path) -> dict[str, str]:
    """What a file says of where it comes from. Raises OriginError, or the error of whatever reads such files."""
    if not path.is_file():
        raise OriginError(
            f"{path}: there is no such file; give a table, an array file, a model or a figure of a run"
        )
    read = READERS.get(path.suffix)
    if read is None:
        raise OriginError(
            f"{path}: files that end with {path.suffix or 'nothing'} do not say where they come from; give one of {', '.join(READERS)}"
        )
    try:
        found = read(path)
    except UserError:
        raise
    except Exception as error:
        raise OriginError(
            f"{path}: cannot be read ({(str(error).splitlines() or ['?'])[0][:80]}); delete it and run the workflow again"
        ) from None
    if "config_sha256" not in found:
        raise OriginError(
            f"{path}: does not say where it comes from; this version's workflow did not write it"
        )
    return {
        key: found[key]
        for key in (
            *(key for key in FIRST if key in found),
            *(key for key in found if key not in FIRST),
        )
    }


def _table(path: Path) -> dict[str, str]:
    from ..storage.tables import read_about

    return {key: value for key, value in read_about(path).items() if key != "pandas"}


def _arrays(path: Path) -> dict[str, str]:
    import h5py

    with h5py.File(path, "r") as file:
        return {key: str(value) for key, value in file.attrs.items()}


def _model(path: Path) -> dict[str, str]:
    from ..storage.checkpoints import load_state

    return dict(load_state(path, "run the workflow again").get("about", {}))


def _picture(path: Path) -> dict[str, str]:
    from PIL import Image

    with Image.open(path) as picture:
        if path.suffix == ".gif":
            return json.loads(picture.info.get("comment", b"{}"))
        return {key: value for key, value in picture.info.items() if isinstance(value, str)}


def _document(path: Path) -> dict[str, str]:
    found = re.search(rb"/Keywords \((.*?)(?<!\\)\)", path.read_bytes(), re.DOTALL)
    return json.loads(re.sub(rb"\\(.)", rb"\1", found[1])) if found else {}


READERS: dict[str, Callable[[Path], dict[str, str]]] = {
    ".parquet": _table, ".h5": _arrays, ".predictor": _model, ".policy": _model, ".png": _picture, ".gif": _picture, ".pdf": _document,
}  # fmt: skip
"""How files that end so are read."""
