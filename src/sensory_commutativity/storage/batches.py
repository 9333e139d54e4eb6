"""Long computations in batches: a killed job loses at most the batch that it was working on."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pandas as pd

from .. import __version__
from ..errors import TableError
from ..progress import progress
from .columns import Column
from .hashing import digest, sha256
from .tables import read_stored_table, write_table

UNITS = "batch_units"
"""Metadata key of the units in a batch, ``START-STOP``."""
Compute = Callable[[int, int], pd.DataFrame]
"""Rows of the units start <= i < stop; they must not depend on how units are cut into batches."""


def compute_in_batches(
    out: Path,
    name: str,
    columns: Sequence[Column],
    compute: Compute,
    units: tuple[int, int],
    settings: str,
    batch: int = 100,
    sources: Sequence[Path] = (),
    metadata: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Compute rows of units in batches, which are kept beside `out` until :func:`remove_batches`.

    Parameters
    ----------
    out : Path
        File that the caller will write; finished batches lie in a hidden folder named after it.
    name, columns : str, sequence of Column
        The table that `compute` returns rows of.
    compute : callable
    units : tuple of int
        First unit, and one past the last.
    settings : str
        Everything that the rows depend on, apart from `sources`. Batches that were computed with
        other settings, or by another version of the package, are removed.
    batch : int
        Units in a batch; a few seconds of work.
    sources : sequence of Path
        Files that the rows are computed from. Batches computed from other contents are removed.
    metadata : mapping, optional
        Stored in the batches.
    """
    folder = _folder(out)
    kept = folder / digest(__version__, settings, [sha256(path) for path in sources])
    for stale in [path for path in folder.glob("*") if path != kept]:
        shutil.rmtree(stale) if stale.is_dir() else stale.unlink()
    start, stop = units
    frames = []
    bounds = [(low, min(low + batch, stop)) for low in range(start, stop, batch)]
    for low, high in progress(bounds, out.stem, "batch"):
        path = kept / f"{low:08d}-{high:08d}.parquet"
        units_of_batch = {UNITS: f"{kept.name} {low}-{high}"}
        try:
            stored = read_stored_table(path, name, columns)
            if stored.metadata.get(UNITS) != units_of_batch[UNITS]:
                raise TableError(f"{path}: is another batch")
            frame = stored.frame
        except TableError:
            frame = compute(low, high)
            write_table(path, name, columns, frame, {**(metadata or {}), **units_of_batch})
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def remove_batches(out: Path) -> None:
    """Remove the batches that were kept for `out`."""
    shutil.rmtree(_folder(out), ignore_errors=True)


def _folder(out: Path) -> Path:
    return out.with_name(f".{out.name}.batches")
