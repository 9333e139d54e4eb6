"""A small run with a file of every type."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sensory_commutativity.runs.checksums import MANIFEST, write_manifest
from sensory_commutativity.storage.arrays import write_arrays
from sensory_commutativity.storage.checkpoints import save_state
from sensory_commutativity.storage.tables import write_table
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import write_resolved
from sensory_commutativity.studies.plotting import GifWriter, save_figure
from sensory_commutativity.studies.provenance import provenance
from sensory_commutativity.studies.registry import find_table

TABLE = "tables/flatland_scp.parquet"
SHARD = "data/flatland_experiments/furnished.1-of-2.parquet"
ARRAYS = "data/mask_pairs/training.1-of-1.h5"
PREDICTOR = "models/masks/raft.predictor"
POLICY = "models/navigation/full.1.policy"
GIF, PDF, PNG = "figures/a.gif", "figures/a.pdf", "figures/a.png"
FILES = (SHARD, ARRAYS, "data/apartment_ready/a.json", PREDICTOR, POLICY, TABLE, GIF, PDF, PNG)
OTHER_FILES = (
    "logs/a.log", "benchmarks/a.tsv", "tables/.a.parquet", "data/.batches/a.parquet",
    "tables/notes.txt", "report.html",
)  # fmt: skip


def scp_table(values: list[float], n: int = 100, width: float = 0.05) -> pd.DataFrame:
    """A table flatland_scp with these values."""
    rows = [
        ("furnished", "polyphemus", 50, f"dof-{i}", 0.0, n, round(v * n), v, v - width, v + width)
        for i, v in enumerate(values)
    ]
    columns = [column.name for column in find_table("flatland_scp").columns]
    return pd.DataFrame(rows, columns=columns)


def write_scp(path: Path, values: list[float], config: Config, table: str = "flatland_scp") -> None:
    """Write a table flatland_scp, or another with its columns, with these values."""
    columns = find_table(table).columns
    write_table(path, table, columns, scp_table(values), provenance(config))


def draw() -> Figure:
    figure = Figure(figsize=(1, 1))
    figure.add_subplot().plot([0, 1])
    return figure


def write_run(run: Path, config: Config) -> None:
    """Write FILES, OTHER_FILES, the settings and the checksums."""
    for name in (*FILES, *OTHER_FILES):
        (run / name).parent.mkdir(parents=True, exist_ok=True)
    metadata = provenance(config)
    write_resolved(config, run / "config.yaml")
    write_scp(run / TABLE, [0.5], config)
    write_scp(run / SHARD, [0.5, 0.25], config)  # a shard has another name than its table
    write_arrays(run / ARRAYS, "pairs", {"a": np.arange(300.0)}, metadata)
    (run / "data/apartment_ready/a.json").write_text('{"seconds": 1.5}\n')
    save_state(run / PREDICTOR, {"about": metadata, "weights": {}})
    save_state(run / POLICY, {"about": metadata})
    save_figure(draw, run / PNG, config)
    figure = draw()
    with GifWriter(figure, run / GIF, config, fps=5, dpi=40) as writer:
        writer.grab_frame()
        figure.axes[0].plot([1, 0])
        writer.grab_frame()
    for name in OTHER_FILES:
        (run / name).write_text("not a result")
    for name in FILES:
        os.utime(run / name, (1e9, 1e9))
    write_manifest(run / MANIFEST)


def damage(path: Path, data: bytes) -> None:
    """Replace the content of a file but not its time of modification."""
    stat = path.stat()
    path.write_bytes(data)
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))


def set_time_after_checksums(run: Path, name: str) -> None:
    """Set the time of modification of a file to a second after that of the checksums."""
    later = (run / MANIFEST).stat().st_mtime_ns + 10**9
    os.utime(run / name, ns=(later, later))
