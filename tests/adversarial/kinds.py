"""A file of every kind that a stage reads, and how it is read.

Reading returns bytes that hold everything that the file contributes to a result, or raises
UserError.
"""

from __future__ import annotations

import hashlib
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import torch

from sensory_commutativity import Corridor, measure
from sensory_commutativity.change_detection.models.view_classifier import ViewClassifier
from sensory_commutativity.change_detection.pair_files import read_pairs
from sensory_commutativity.change_detection.predictor import MaskPredictor, load_predictor
from sensory_commutativity.errors import UserError
from sensory_commutativity.measurement.measurement import Measurement
from sensory_commutativity.runs.verify import find_damage
from sensory_commutativity.storage.arrays import pack_masks, write_arrays
from sensory_commutativity.storage.batches import compute_in_batches
from sensory_commutativity.storage.checkpoints import Checkpoint
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.checks import metadata_of
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.flatland.builders import DOFS, experiment_runs
from sensory_commutativity.studies.flatland.tables.flatland_experiments import flatland_experiments
from sensory_commutativity.studies.flatland.tables.flatland_scp import flatland_scp
from sensory_commutativity.studies.loading import load, write_resolved
from sensory_commutativity.studies.plotting import GifWriter, save_figure
from sensory_commutativity.studies.registry import find_product
from sensory_commutativity.worlds.apartment.scenes import shapes
from tests.runs.examples import draw
from tests.studies.examples import write_frame


class Kind(NamedTuple):
    """A file, and a function that reads it."""

    name: str
    path: Path
    read: Callable[[], bytes]


def _bytes(frame: pd.DataFrame) -> bytes:
    return frame.to_json(double_precision=15).encode() + str(frame.dtypes.to_dict()).encode()


def experiment_rows(config: Config) -> pd.DataFrame:
    """A complete table flatland_experiments of made-up distances."""
    rng = np.random.default_rng(0)
    rows = [
        (*run[:3], dof, i, i, float(rng.choice([0.0, 12.5])))
        for run in config.flatland.runs()
        for i in range(run.experiments)
        for dof in DOFS
    ]
    return pd.DataFrame(rows, columns=flatland_experiments.column_names)


def write_shards(config: Config, folder: Path) -> list[Path]:
    """All shards of flatland_experiments, in order."""
    frame, paths, start = experiment_rows(config), [], 0
    for shard in flatland_experiments.shards.all(config):
        stop = start + (shard.stop - shard.start) * len(DOFS)
        paths.append(write_frame(flatland_experiments, config, folder, frame[start:stop], shard))
        start = stop
    return paths


def write_scp(config: Config, folder: Path) -> tuple[Path, Path]:
    """The tables flatland_experiments and flatland_scp."""
    source = write_frame(flatland_experiments, config, folder, experiment_rows(config))
    out = folder / "flatland_scp.parquet"
    runner.write_product(flatland_scp, config, [source], out)
    return source, out


def table_kinds(config: Config, folder: Path) -> list[Kind]:
    """A shard, a table that is computed from, and one that figures are drawn from."""
    shard = write_shards(config, folder)[0]
    experiments, scp = write_scp(config, folder)

    def read_shard() -> bytes:
        frame, extra = runner.read_shards(flatland_experiments, config, [shard])
        return _bytes(frame) + json.dumps(extra).encode()

    return [
        Kind("shard", shard, read_shard),
        Kind("experiments", experiments,
             lambda: _bytes(runner.read_product(flatland_experiments, config, experiments))),
        Kind("scp", scp, lambda: _bytes(runner.read_product(flatland_scp, config, scp))),
    ]  # fmt: skip


def measurement_kind(folder: Path) -> Kind:
    """A file of ``measure(...).save``."""
    path = folder / "corridor.parquet"
    measure(Corridor(wall=3), n=5, length=5, check=False).save(path)
    return Kind(
        "measurement", path, lambda: repr(Measurement.load(path)).encode() + _provenance(path)
    )


def _provenance(path: Path) -> bytes:
    return json.dumps(dict(Measurement.load(path).provenance), sort_keys=True).encode()


def batch_kind(folder: Path) -> Kind:
    """A batch that a killed job has left."""
    out = folder / "numbers.parquet"

    def compute(start: int, stop: int) -> pd.DataFrame:
        return pd.DataFrame(
            dict(zip(flatland_experiments.column_names,
                     ("a", "b", 1, "c", np.arange(start, stop), 5, 0.5), strict=True))
        )  # fmt: skip

    def read() -> bytes:
        args = out, "flatland_experiments", flatland_experiments.columns, compute, (0, 20), "s"
        return _bytes(compute_in_batches(*args, batch=10))

    read()
    return Kind("batch", next((folder / ".numbers.parquet.batches").rglob("*.parquet")), read)


def arrays_kind(config: Config, folder: Path) -> Kind:
    """A shard of pairs of pictures."""
    product = find_product("mask_pairs")
    shard = product.shards.of_run(config, "validation")[0]
    rng, path = np.random.default_rng(0), folder / product.file(shard).name
    arrays = dict(
        pictures=rng.integers(0, 256, (3, 2, 16, 16, 3), np.uint8),
        masks=pack_masks(rng.random((3, 2, 16, 16)) < 0.5),
        outcome=np.arange(3, dtype=np.int8),
        kind=np.zeros(3, np.int8),
        scene=np.zeros(3, np.int32),
    )
    texts = {"outcomes": "[]", "kinds": '["random"]', **metadata_of(product, config, shard)}
    write_arrays(path, "mask_pairs", arrays, texts)

    def read() -> bytes:
        runner._read_input(product, config, [path], {})
        return b"".join(repr(part).encode() + np.asarray(part).tobytes()
                        for part in read_pairs(path))  # fmt: skip

    return Kind("pairs", path, read)


def small_predictor(path: Path) -> None:
    """A FlowNet of few weights with a view classifier."""
    from sensory_commutativity.change_detection.models.flownet import MaskFlowNet

    torch.manual_seed(0)
    model, classifier = MaskFlowNet(0.02), ViewClassifier(4)
    MaskPredictor("flownet", model, view_classifier=classifier).save(path, {"profile": "test"})


def model_kinds(folder: Path) -> list[Kind]:
    """A predictor, and the checkpoint of a training run."""
    path = folder / "flownet.predictor"
    small_predictor(path)

    def read_predictor() -> bytes:
        predictor = load_predictor(path)
        assert predictor.model is not None and predictor.view_classifier is not None
        networks = predictor.model.state_dict(), predictor.view_classifier.state_dict()
        weights = [v.numpy().tobytes() for state in networks for v in state.values()]
        return repr(predictor.thresholds).encode() + b"".join(weights)

    checkpoint = Checkpoint(folder / "out.policy", "settings")
    checkpoint.save({"policy": {"weight": torch.arange(50.0)}, "curve": [{"step": 1}]})
    return [
        Kind("predictor", path, read_predictor),
        Kind("checkpoint", checkpoint.path, lambda: repr(checkpoint.load()).encode()),
    ]


def settings_kind(config: Config, folder: Path) -> Kind:
    """The settings of a run, as the workflow writes them."""
    path = folder / "config.yaml"
    write_resolved(config, path)
    return Kind("settings", path, lambda: load(path).digest().encode())


def figure_kinds(config: Config, folder: Path) -> list[Kind]:
    """A figure as PNG and PDF, and an animation: what ``run verify`` reads."""
    paths = [folder / name for name in ("a.png", "a.pdf", "a.gif")]
    save_figure(draw, paths[0], config)
    figure = draw()
    with GifWriter(figure, paths[2], config, fps=5, dpi=40) as writer:
        writer.grab_frame()

    def reader(path: Path) -> Callable[[], bytes]:
        def read() -> bytes:
            damage = find_damage(path)
            if damage:
                raise UserError(f"{path}: {damage}")
            if path.suffix == ".png":  # a broken mark at its end is no part of the picture
                import io

                from PIL import Image

                return np.asarray(Image.open(io.BytesIO(path.read_bytes()))).tobytes()
            return path.read_bytes()

        return read

    return [Kind(path.suffix[1:], path, reader(path)) for path in paths]


def shape_kind(folder: Path, monkeypatch) -> Kind:
    """A collision shape in the user's cache: damaged ones are made again."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
    points = np.random.default_rng(0).random((30, 3))
    path = shapes.write_shape(points)
    return Kind("shape", path, lambda: shapes.write_shape(points).read_bytes())


def compiled_kinds(folder: Path) -> list[Kind]:
    """Index and code of a function that numba compiled: damaged ones count as missing."""
    from sensory_commutativity.compiled import HashedCacheFile

    cache = HashedCacheFile(str(folder), "function", ("stamp", 1))
    code = pickle.dumps(list(range(200)))
    cache.save("signature", code)

    def read() -> bytes:
        found = cache.load("signature")
        if found is None:
            cache.save("signature", code)
            found = cache.load("signature")
        return found

    files = sorted(folder.glob("function.*"))
    assert len(files) == 2
    return [Kind(path.suffix[1:], path, read) for path in files]


def all_kinds(config: Config, folder: Path, monkeypatch) -> list[Kind]:
    """A file of every kind, in `folder`."""
    assert experiment_runs(config)
    return [
        *table_kinds(config, folder),
        measurement_kind(folder),
        batch_kind(folder),
        arrays_kind(config, folder),
        *model_kinds(folder),
        settings_kind(config, folder),
        *figure_kinds(config, folder),
        shape_kind(folder, monkeypatch),
        *compiled_kinds(folder),
    ]


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
