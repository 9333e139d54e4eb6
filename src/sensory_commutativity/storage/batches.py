"""Long work in batches, so that a kill loses the batch at hand and nothing else."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pandas as pd

from .. import __version__
from ..errors import TableError
from ..progress import progress
from ..runs.checksums import sha256
from ..studies.config import Config
from .tables import read_table, write_table

Compute = Callable[[int, int], pd.DataFrame]
"""The rows of units start <= i < stop; what it returns may not depend on how units are cut into batches."""


def write_in_batches(
    name: str,
    compute: Compute,
    start: int,
    stop: int,
    out: Path,
    config: Config,
    settings: str,
    batch: int = 100,
    sources: Sequence[Path] = (),
    about: Mapping[str, str] | None = None,
) -> None:
    """Write a table, in batches of which a killed run keeps the finished ones (:func:`in_batches`); `about` goes into the file."""
    write_table(
        name,
        in_batches(name, compute, start, stop, out, config, settings, batch, sources),
        out,
        config,
        about,
    )
    forget_batches(out)


def in_batches(
    name: str,
    compute: Compute,
    start: int,
    stop: int,
    out: Path,
    config: Config,
    settings: str,
    batch: int = 100,
    sources: Sequence[Path] = (),
) -> pd.DataFrame:
    """Compute units `start` to `stop`, keeping finished batches beside `out` until all is done.

    Parameters
    ----------
    name : str
        The table that `compute` gives rows of.
    out : Path
        The file that the caller will write; finished batches lie in a folder named after it, which :func:`forget_batches` removes.
    settings : str
        All that the rows depend on beside `sources`; batches of other settings, or of another version of the package, are thrown away.
    batch : int
        Units in a batch; some seconds of work.
    sources : sequence of Path
        Files that the rows are made from; batches of other contents are thrown away, too.
    """
    folder = _folder(out)
    kept = folder / _digest(settings, sources)
    for stale in [p for p in folder.glob("*") if p != kept]:
        shutil.rmtree(stale) if stale.is_dir() else stale.unlink()
    frames = []
    bounds = [(low, min(low + batch, stop)) for low in range(start, stop, batch)]
    for low, high in progress(bounds, out.stem, "batch"):
        path = kept / f"{low:08d}-{high:08d}.parquet"
        try:
            frame = read_table(name, path)
        except TableError:
            frame = compute(low, high)
            write_table(name, frame, path, config)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def forget_batches(out: Path) -> None:
    """Remove the batches kept for `out`, now that it is written."""
    shutil.rmtree(_folder(out), ignore_errors=True)


def _digest(settings: str, sources: Sequence[Path]) -> str:
    content = hashlib.sha256(f"{__version__} {settings}".encode())
    for path in sources:
        content.update(sha256(path).encode())
    return content.hexdigest()[:16]


def _folder(out: Path) -> Path:
    return out.with_name(f".{out.name}.batches")
