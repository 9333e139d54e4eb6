"""Checks of what a stage reads: was it computed with these settings, and is it complete?"""

from __future__ import annotations

import shlex
from pathlib import Path

import pandas as pd

from ..errors import TableError
from ..storage.files import printable
from .config import Config
from .declarations import Expectation, Expected, Model, Product, Shard, Table
from .provenance import provenance
from .registry import KINDS, settings_digest

SETTINGS = "settings_sha256"
"""Metadata key of :func:`.registry.settings_digest`."""
UNITS = "units"
"""Metadata key of the units in a shard, ``START-STOP``."""
RERUN = "run the workflow again"


def recreate(product: Product, config: Config, shard: Shard | None) -> str:
    """The command that computes a file again."""
    words = ["sencom", "train" if isinstance(product, Model) else KINDS[type(product)]]
    words.append(product.name)
    if shard is not None:
        words += ["--run" if isinstance(product, Model) else "--shard", shard.name]
    return shlex.join([*words, "--config", str(config.folder / "config.yaml")])


def remedy(product: Product, config: Config, shard: Shard | None) -> str:
    """What messages about a file of a product advise."""
    return f"delete it and {RERUN}, or: {recreate(product, config, shard)}"


def metadata_of(product: Product, config: Config, shard: Shard | None) -> dict[str, str]:
    """Provenance of a product or a shard of it, with the hash of its settings."""
    metadata = {
        **provenance(config),
        SETTINGS: settings_digest(product, config, shard.run if shard else None),
    }
    return metadata | ({UNITS: f"{shard.start}-{shard.stop}"} if shard else {})


def check_origin(
    metadata: dict[str, str], product: Product, config: Config, shard: Shard | None, path: Path
) -> None:
    """Check that a file was computed for this configuration, and for this shard.

    Raises
    ------
    TableError
        If its profile, root seed, settings or units are others.
    """
    digest = settings_digest(product, config, shard.run if shard else None)
    expected = {"profile": config.profile, "root_seed": str(config.seed), SETTINGS: digest}
    if shard is not None and not isinstance(product, Model):
        expected[UNITS] = f"{shard.start}-{shard.stop}"
    shown = {"profile": "profile", "root_seed": "root seed", UNITS: "units"}
    for key, value in expected.items():
        found = printable(str(metadata.get(key, "none")))
        if found != value:
            reason = f"{shown[key]} ({found:.60})" if key in shown else "settings"
            raise TableError(
                f"{path}: was computed with other {reason} than this configuration has; "
                f"{remedy(product, config, shard)}"
            )


def check_complete(
    frame: pd.DataFrame, product: Table, config: Config, path: Path, culprit: str = "it"
) -> None:
    """Raise TableError if rows that the configuration asks for are missing, or others are there.

    `culprit` says what to delete: by default the file `path` itself.
    """
    again = f"delete {culprit} and {RERUN}, or: {recreate(product, config, None)}"
    if product.expected is not None:
        check_rows(frame, product.expected(config), path, again)
    elif not len(frame):
        raise TableError(f"{path}: has no rows; {again}")


def check_shard(
    frame: pd.DataFrame, product: Table, config: Config, shard: Shard, path: Path
) -> None:
    """Raise TableError if a shard lacks rows of its units, or has rows of others."""
    again = remedy(product, config, shard)
    if product.expected_shard is not None:
        check_rows(frame, product.expected_shard(config, shard), path, again)
    elif not len(frame):
        raise TableError(f"{path}: has no rows; {again}")


def check_rows(frame: pd.DataFrame, expected: Expectation, path: Path, again: str) -> None:
    """Raise TableError unless `frame` has the rows that are expected, no more and no less."""
    for one in expected if isinstance(expected, tuple) else (expected,):
        if one.columns:
            _check_groups(frame, one, path, again)


def _check_groups(frame: pd.DataFrame, expected: Expected, path: Path, again: str) -> None:
    columns = list(expected.columns)
    sizes = frame.groupby(columns, sort=False, dropna=False).size() if len(frame) else pd.Series()
    found = {key if isinstance(key, tuple) else (key,): int(n) for key, n in sizes.items()}
    wrong = {
        "missing": [key for key in expected.counts if key not in found],
        "not part of the configuration": [key for key in found if key not in expected.counts],
        "incomplete": [
            key for key, n in expected.counts.items() if n is not None and found.get(key, n) != n
        ],
    }
    for problem, keys in wrong.items():
        if keys:
            first = ", ".join(
                f"{column} {value}" for column, value in zip(columns, keys[0], strict=True)
            )
            more = f" and {len(keys) - 1} more" if len(keys) > 1 else ""
            raise TableError(
                f"{path}: {len(keys)} of {len(expected.counts)} groups of rows {problem}: "
                f"{printable(first)}{more}; {again}"
            )
