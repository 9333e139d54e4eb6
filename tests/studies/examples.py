"""Configurations and files that several tests of the studies make."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from sensory_commutativity.storage.tables import write_table
from sensory_commutativity.studies import runner
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.declarations import Product, Shard, Table
from sensory_commutativity.studies.loading import merge, validate


def overlay(config: Config, **sections: Any) -> Config:
    """The configuration with `sections` merged over it, validated again."""
    return validate(merge(config.model_dump(mode="json"), sections))


def write_shards(
    product: Product, config: Config, folder: Path, run: str, inputs: Sequence[Path] = ()
) -> list[Path]:
    """Compute all shards of a run and write them to a folder; their files, in order."""
    assert product.shards is not None
    paths = []
    for shard in product.shards.of_run(config, run):
        paths.append(folder / product.file(shard).name)
        runner.write_product(product, config, inputs, paths[-1], shard)
    return paths


def write_frame(
    product: Table, config: Config, folder: Path, frame: pd.DataFrame, shard: Shard | None = None
) -> Path:
    """Write made-up rows as a table, or as a shard of it, as if the study had computed them."""
    path = folder / product.file(shard).name
    metadata = runner.metadata_of(product, config, shard)
    write_table(path, product.name, product.columns, frame, metadata)
    return path
