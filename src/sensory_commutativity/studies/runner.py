"""Computing what is declared: finds and checks the inputs, reads tables, and writes the results."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from ..errors import TableError, UserError
from ..storage.batches import UNITS as BATCH_UNITS
from ..storage.batches import compute_in_batches, remove_batches
from ..storage.hashing import sha256
from ..storage.seal import SEAL_KEY
from ..storage.tables import ROWS_HASH, check_key, read_stored_table, write_table
from .checks import (
    RERUN,
    SETTINGS,
    UNITS,
    check_complete,
    check_origin,
    check_shard,
    metadata_of,
    remedy,
)
from .config import Config
from .declarations import (
    Animation,
    Arrays,
    Batched,
    Figure,
    Model,
    Product,
    Shard,
    Table,
    TrainingOutput,
)
from .provenance import INPUTS, computed_from, provenance
from .registry import find_table, input_shards, settings_digest


def write_product(
    product: Product,
    config: Config,
    inputs: Sequence[Path],
    out: Path,
    shard: Shard | None = None,
    curve: Path | None = None,
) -> None:
    """Compute a table, arrays, a model, a figure or an animation, and write it.

    Parameters
    ----------
    product : Product
    config : Config
    inputs : sequence of Path
        All files that the declaration names, in any order; recognized by their file names.
    out : Path
        File to write.
    shard : Shard, optional
        Compute this shard alone. For a model or an animation: its run.
    curve : Path, optional
        File for the training curve of a model.

    Raises
    ------
    UserError
        If an input is missing, superfluous, damaged, incomplete, or was computed with other
        settings.
    """
    if isinstance(product, Table) and product.shards is not None and shard is None:
        _gather(product, config, inputs, out)
        return
    files = match_inputs(product, config, inputs, shard)
    hashes: dict[str, str] = {}
    values = [_read_input(source, config, paths, hashes) for source, paths in files]
    with computed_from(hashes):
        _compute(product, config, files, values, out, shard, curve)


def _compute(
    product: Product,
    config: Config,
    files: list[tuple[Product, list[Path]]],
    values: list[Any],
    out: Path,
    shard: Shard | None,
    curve: Path | None,
) -> None:
    """Compute a product from its inputs, and write it."""
    sources = [path for _, paths in files for path in paths]
    if isinstance(product, Table):
        _write_table(product, config, values, sources, out, shard)
    elif isinstance(product, Arrays):
        from ..storage.arrays import write_arrays  # imports h5py

        content, texts = product.compute(*values, config, *([shard] if shard else []))
        write_arrays(out, product.name, content, {**texts, **metadata_of(product, config, shard)})
    elif isinstance(product, Model):
        assert shard is not None
        output = training_output(product, config, shard.run, out, curve)
        product.compute(*values, config, shard.run, output)
    elif isinstance(product, Animation):
        product.compute(*values, config, shard.run if shard else None, out)
    elif isinstance(product, Figure):
        from .plotting import save_figure  # imports matplotlib

        names = [source.name for source, _ in files]
        save_figure(lambda: product.compute(dict(zip(names, values, strict=True)), config),
                    out, config)  # fmt: skip


def _write_table(
    product: Table,
    config: Config,
    values: list[Any],
    sources: list[Path],
    out: Path,
    shard: Shard | None,
) -> None:
    metadata = metadata_of(product, config, shard)
    result = product.compute(*values, config, *([shard.run] if shard else []))
    if isinstance(result, Batched):
        if result.units is not None:
            units = (0, result.units)
        else:
            assert shard is not None
            units = (shard.start, shard.stop)
        metadata |= result.metadata
        frame = compute_in_batches(
            out, product.name, product.columns, result.compute, units,
            f"{metadata[SETTINGS]} {result.metadata}", result.size, sources, metadata,
        )  # fmt: skip
    else:
        frame = result
    write_table(out, product.name, product.columns, frame, metadata)
    remove_batches(out)


def write_shard(product: Table, config: Config, run: str, frame: pd.DataFrame, path: Path) -> None:
    """Write the rows of a run that is never cut, which something else than the table computed."""
    assert product.shards is not None
    (shard,) = product.shards.of_run(config, run)
    write_table(path, product.name, product.columns, frame, metadata_of(product, config, shard))


def _gather(product: Table, config: Config, paths: Sequence[Path], out: Path) -> None:
    """Concatenate all shards of a table, in order."""
    assert product.shards is not None
    shards = product.shards.all(config)
    files = _match({product.file(shard).name: shard for shard in shards}, paths, product.name)
    frame, extra = read_shards(product, config, [files[product.file(s).name] for s in shards])
    if product.gather is not None:
        frame = product.gather(frame)
    check_complete(frame, product, config, out, "its shards")
    check_key(frame, product.key, out, "its shards")
    metadata = {**metadata_of(product, config, None), **extra}
    write_table(out, product.name, product.columns, frame, metadata)


def read_product(product: Table, config: Config, path: Path) -> pd.DataFrame:
    """Read a whole table and check its content, its key, its completeness and its provenance.

    Raises
    ------
    TableError
        With the file, what is wrong and the remedy.
    """
    return _read_whole(product, config, path)[0]


def _read_whole(product: Table, config: Config, path: Path) -> tuple[pd.DataFrame, dict[str, str]]:
    frame, metadata = read_stored_table(
        path, product.name, product.columns, remedy(product, config, None)
    )
    check_origin(metadata, product, config, None, path)
    check_complete(frame, product, config, path)
    return frame, metadata


def read_shards(
    product: Table, config: Config, paths: Sequence[Path]
) -> tuple[pd.DataFrame, dict[str, str]]:
    """Read shards of a table, and the further metadata of the first.

    Hashes in the further metadata (keys that end with ``sha256``) must be the same in all shards.

    Raises
    ------
    TableError
        If a shard is damaged, of another run, or lacks rows; with its file and the remedy.
    """
    shards = _shards_by_file(product, config)
    frames = []
    extra: dict[str, str] | None = None
    for path in paths:
        shard = shards[path.name]
        assert shard is not None
        frame, metadata = read_stored_table(
            path, product.name, product.columns, remedy(product, config, shard)
        )
        check_origin(metadata, product, config, shard, path)
        check_shard(frame, product, config, shard, path)
        frames.append(frame)
        own = _own_metadata(metadata)
        extra = own if extra is None else extra
        for key in own.keys() | extra.keys():
            if key.endswith("sha256") and own.get(key) != extra.get(key):
                raise TableError(
                    f"{path}: its {key} differs from that of {paths[0]}; delete the shards and "
                    f"{RERUN}"
                )
    return pd.concat(frames, ignore_index=True), extra or {}


def match_inputs(
    product: Product, config: Config, paths: Sequence[Path], shard: Shard | None
) -> list[tuple[Product, list[Path]]]:
    """Find the files of every declared input among `paths`, by their names.

    Raises
    ------
    UserError
        If one is missing, given twice, or not declared.
    """
    declared = input_shards(product, config, shard)
    wanted = {source.file(one).name: None for source, shards in declared for one in shards}
    files = _match(wanted, paths, product.name)
    return [
        (source, [files[source.file(one).name] for one in shards]) for source, shards in declared
    ]


def _match(wanted: dict[str, Any], paths: Sequence[Path], name: str) -> dict[str, Path]:
    """File name -> path, of exactly the names that are wanted."""
    files: dict[str, Path] = {}
    for path in paths:
        if path.name not in wanted:
            raise UserError(f"{path}: is no input of {name}; leave it out")
        if path.name in files:
            raise UserError(f"{path}: given twice as an input of {name}; give it once")
        files[path.name] = path
    missing = [file for file in wanted if file not in files]
    if missing:
        more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        raise UserError(f"{name} needs the input {missing[0]}{more}; give the path of each file")
    return files


def _read_input(source: Product, config: Config, paths: list[Path], hashes: dict[str, str]) -> Any:
    """A table as a DataFrame, a model as its path, arrays as the paths of their files.

    All must have been computed with the settings of `config`. Adds the hashes of the contents of
    tables, models and arrays that are one file to `hashes`: those of shards would depend on how
    work is cut.
    """
    if isinstance(source, Table):
        if paths[0].name == source.file().name:
            frame, metadata = _read_whole(source, config, paths[0])
            hashes[str(source.file())] = metadata[ROWS_HASH]
            return frame
        return read_shards(source, config, paths)[0]
    shards = _shards_by_file(source, config)
    for path in paths:
        shard = shards[path.name]
        again = remedy(source, config, shard)
        if isinstance(source, Arrays):
            from ..storage.arrays import read_array_metadata  # imports h5py

            metadata = read_array_metadata(path, source.name, again)
        else:
            from ..storage.checkpoints import load_state  # imports torch

            metadata = load_state(path, again.removeprefix("delete it and ")).get("about", {})
        check_origin(metadata, source, config, shard, path)
    if len(paths) == 1:
        hashes[str(source.file(shards[paths[0].name]))] = sha256(paths[0])
    return paths[0] if isinstance(source, Model) and len(paths) == 1 else paths


def _shards_by_file(product: Product, config: Config) -> dict[str, Shard | None]:
    """File name -> shard, of all shards; None for a product that has none."""
    if product.shards is None:
        return {product.file(None).name: None}
    runs = product.shards.runs(config)
    if isinstance(product, Model):  # of all seeds, of which each is one shard
        shards = [shard for run in runs for shard in product.shards.of_run(config, run)]
    else:
        shards = product.shards.all(config)
    return {product.file(shard).name: shard for shard in shards}


def training_output(
    product: Model, config: Config, run: str, out: Path, curve: Path | None
) -> TrainingOutput:
    """What the training of a run is given: files to write, and its provenance."""
    digest = settings_digest(product, config, run)

    def write_curve(frame: pd.DataFrame) -> None:
        assert product.curve is not None and curve is not None
        write_shard(find_table(product.curve), config, run, frame, curve)

    metadata = {**provenance(config), SETTINGS: digest}
    return TrainingOutput(out, curve or out, digest, metadata, write_curve)


def _own_metadata(metadata: dict[str, str]) -> dict[str, str]:
    """What a shard says of itself beside its provenance."""
    known = {"table", "profile", "config_sha256", "root_seed", SETTINGS, UNITS, INPUTS}
    known |= {"git_commit", "python", "platform", "packages", SEAL_KEY, ROWS_HASH, BATCH_UNITS}
    return {key: value for key, value in metadata.items() if key not in known}
