"""Figures drawn again from the tables beside them, and compared.

The same tables, code and versions of matplotlib give the same picture, point by point.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ..errors import UserError
from ..storage.seal import SEAL_KEY, is_intact, unseal
from ..studies.config import Config
from ..studies.declarations import Arrays, Figure, Table
from ..studies.plotting import render_figure
from ..studies.provenance import INPUTS
from ..studies.registry import configured, input_shards
from .origin import read_own_origin

DRAWN_BY = ("matplotlib", "pillow", "numpy")
"""Packages that decide what a picture looks like."""


def find_stale_figures(
    run: Path, config: Config, names: set[str]
) -> tuple[list[tuple[str, str]], list[str]]:
    """Draw the figures of a run again.

    Parameters
    ----------
    run : Path
    config : Config
    names : set of str
        Files of the run.

    Returns
    -------
    stale : list of (str, str)
        Path of each figure that is not what its tables give, and what differs.
    notes : list of str
        Figures that cannot be drawn.
    """
    stale, notes = [], []
    for figure in configured(Figure, config, optional=config.atlas is not None).values():
        png = str(figure.file())
        if png not in names:
            continue
        try:
            tables = _read_inputs(figure, run, config)
            problem = _compare(figure, tables, config, run / png)
        except UserError as error:
            notes.append(f"{png} cannot be drawn again: {error}")
            continue
        origin = _read_origin(run / png)
        reason = _find_other_reason(origin)
        if problem and reason and INPUTS in origin:  # its tables are compared by their hashes
            notes.append(f"{png} {problem}, but by its record only by {reason}")
        elif problem:
            stale.append((png, f"{problem}, from others{f' or by {reason}' if reason else ''}"))
    return stale, notes


def _read_inputs(figure: Figure, run: Path, config: Config) -> dict[str, Any]:
    """What a figure is drawn from, by name; a run whose tables are others is found elsewhere."""
    from ..storage.tables import read_table

    inputs: dict[str, Any] = {}
    for source, shards in input_shards(figure, config, None):
        path = run / source.file(shards[0])
        if not path.is_file() or path.is_symlink():
            raise UserError(f"{source.name} is not there")
        if isinstance(source, Table):
            inputs[source.name] = read_table(path, source.name, source.columns, require_hash=False)
        elif isinstance(source, Arrays):
            from ..storage.arrays import read_array_metadata

            read_array_metadata(path, source.name)
            inputs[source.name] = [path]
    return inputs


def _compare(figure: Figure, tables: dict[str, Any], config: Config, path: Path) -> str:
    """How the PNG file `path`, and the PDF beside it, differ from the figure drawn again."""
    pdf = path.with_suffix(".pdf")
    has_pdf = pdf.is_file() and not pdf.is_symlink()
    keywords = _stored_metadata(pdf) if has_pdf else {}
    sealed = has_pdf and is_intact(pdf.read_bytes()) is not None
    try:
        drawn_png, drawn_pdf = render_figure(
            lambda: figure.compute(tables, config), keywords, sealed=sealed
        )
    except UserError:
        raise
    except Exception as error:  # tables that are wrong make the drawing fail in any way
        raise UserError(f"{type(error).__name__}, its tables do not fit") from None
    if not _equal_pictures(drawn_png, path.read_bytes()):
        return "is not what its tables give: it was drawn otherwise"
    if has_pdf and keywords and unseal(drawn_pdf) != unseal(pdf.read_bytes()):
        return "has a PDF that is not what its tables give: it was drawn otherwise"
    return ""


def _stored_metadata(pdf: Path) -> dict[str, str]:
    """What a PDF says of itself, in the order in which it was written."""
    return {key: value for key, value in _read_origin(pdf).items() if key != SEAL_KEY}


def _equal_pictures(a: bytes, b: bytes) -> bool:
    try:
        first, second = (
            np.asarray(Image.open(io.BytesIO(data), formats=["PNG"]).convert("RGBA"))
            for data in (a, b)
        )
    except Exception:  # the bytes decide what Pillow's readers raise
        return False
    return first.shape == second.shape and bool((first == second).all())


def _read_origin(path: Path) -> dict[str, str]:
    try:
        return read_own_origin(path)
    except UserError:
        return {}


def _find_other_reason(origin: dict[str, str]) -> str:
    """What else than its tables may make a figure another: other code or packages; "" if nothing.

    A figure without a record may have been drawn by anything.
    """
    from ..storage.provenance import git_commit, package_versions

    if origin.get("git_commit") != git_commit() or git_commit() == "unknown":
        return "other code"
    try:
        packages = json.loads(origin.get("packages", "{}"))
    except ValueError:
        return "other packages"
    now = package_versions()
    return "other packages" if any(packages.get(p) != now[p] for p in DRAWN_BY) else ""
