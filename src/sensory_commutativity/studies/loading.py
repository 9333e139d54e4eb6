"""Reading, checking and writing the configuration."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from ..errors import ConfigError
from ..storage.atomic import atomic_write
from ..storage.files import read_bounded
from ..storage.seal import SEAL, is_intact, seal
from ..storage.settings_errors import check_json_value, explain
from ..storage.yamlfile import MAX_BYTES, read_yaml
from .config import Config
from .paths import relative_paths, resolve_paths

HEAD = "# Written by the workflow: all settings of this run, defaults filled in; sealed at the end."
"""First line of the settings of a run."""


def validate(settings: Any) -> Config:
    """Check settings, the content of a YAML file, and return them as typed models.

    Raises
    ------
    ConfigError
        One line that names the key and the remedy.
    """
    if not isinstance(settings, dict):
        raise ConfigError(
            f"config: expected a mapping of keys to values, got {type(settings).__name__}; "
            "see config/README.md"
        )
    check_json_value(settings, "config")
    try:
        return Config.model_validate_json(json.dumps(settings))
    except ValidationError as error:
        raise ConfigError(explain(error, Config)) from None


def merge(base: dict[str, Any], overlay: dict[str, Any]) -> dict[str, Any]:
    """Merge `overlay` over `base`, recursively where both hold mappings.

    A mapping that is empty replaces what `base` holds.
    """
    merged = dict(base)
    for key, value in overlay.items():
        both = value and isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = merge(merged[key], value) if both else value
    return merged


def remove_keys(merged: dict[str, Any], layers: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return what others have merged from `layers` without the keys that a layer removes.

    Snakemake merges mappings key by key, so that an empty one removes nothing.
    """
    kept: dict[str, Any] = {}
    everything: dict[str, Any] = {}
    for layer in layers:
        kept, everything = merge(kept, layer), _merge_keys(everything, layer)
    return _remove(merged, everything, kept)


def _merge_keys(base: dict[str, Any], overlay: dict[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in overlay.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _merge_keys(merged[key], value) if both else value
    return merged


def _remove(merged: Any, everything: Any, kept: Any) -> Any:
    """Leave out what is in `everything` but not in `kept`; other values come from elsewhere."""
    if not (isinstance(merged, dict) and isinstance(everything, dict) and isinstance(kept, dict)):
        return merged
    return {
        key: _remove(value, everything.get(key), kept.get(key))
        for key, value in merged.items()
        if key not in everything or key in kept or value != everything[key]
    }


def read_settings(*files: str | Path) -> dict[str, Any]:
    """Read YAML files and merge each over the ones before.

    Paths in a file are relative to it; in the result, to the current folder. Raises ConfigError.
    """
    settings: dict[str, Any] = {}
    for file in files:
        _check_seal(Path(file))
        layer = read_yaml(file, ConfigError, "a config file, e.g. config/config.yaml")
        if not isinstance(layer, dict):
            raise ConfigError(
                f"{file}: expected a mapping of keys to values at the top; see config/README.md"
            )
        settings = merge(settings, resolve_paths(layer, Path(file).parent))
    return settings


def _check_seal(path: Path) -> None:
    """Raise ConfigError if a file that the workflow wrote has been changed since."""
    try:
        content = read_bounded(path, ConfigError, "give the path of a config file", MAX_BYTES)
    except OSError:
        return  # the reader of YAML says why
    intact = is_intact(content)
    if intact is False or (intact is None and content.startswith(HEAD.encode())):
        raise ConfigError(
            f"{path}: damaged or changed since the workflow wrote it, its content does not match "
            "its hash; run the workflow again, or delete its last line if you meant to change it"
        )


def load(*files: str | Path) -> Config:
    """Read YAML files, merge each over the ones before, and check. Raises ConfigError."""
    return validate(read_settings(*files))


def write_resolved(config: Config, path: Path) -> None:
    """Write all settings with every default filled in, as YAML.

    Paths are relative to the file. A file that has the same content already is not touched.
    """
    settings = relative_paths(config.model_dump(mode="json"), path.parent)
    text = f"{HEAD}\n{yaml.safe_dump(settings, sort_keys=False)}# {SEAL}\n"
    content = seal(text.encode())
    if path.is_file() and path.read_bytes() == content:
        return
    with atomic_write(path) as temporary:
        temporary.write_bytes(content)


def json_schema() -> dict[str, Any]:
    """The JSON schema of the configuration."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Config.model_json_schema()}
