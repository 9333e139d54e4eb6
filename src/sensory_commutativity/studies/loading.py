"""From YAML files to a checked configuration, and back."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from ..errors import ConfigError
from ..storage.settings_errors import explain, refuse_what_json_has_not
from ..storage.yamlfile import read_yaml
from .config import Config
from .flatland.config import AgentConfig


def validate(settings: Any) -> Config:
    """Check settings (what a YAML file holds) and return them typed. Raises ConfigError with one line that names the key and the remedy."""
    if not isinstance(settings, dict):
        raise ConfigError(
            f"config: expected a mapping of keys to values, got {type(settings).__name__}; see config/README.md"
        )
    refuse_what_json_has_not(settings, "config")
    try:
        return Config.model_validate_json(json.dumps(settings))
    except ValidationError as error:
        raise ConfigError(explain(error, Config)) from None


def merge(base: dict[str, Any], overlay: dict[str, Any]) -> dict[str, Any]:
    """`base` with the values of `overlay` put over it, mapping by mapping."""
    merged = dict(base)
    for key, value in overlay.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = merge(merged[key], value) if both else value
    return merged


def load(*files: str | Path) -> Config:
    """Read YAML files, each laid over the ones before, and check the result. Raises ConfigError."""
    settings: dict[str, Any] = {}
    for file in files:
        layer = read_yaml(file, ConfigError, "a config file, e.g. config/default.yaml")
        if not isinstance(layer, dict):
            raise ConfigError(
                f"{file}: expected a mapping of keys to values at the top; see config/README.md"
            )
        settings = merge(settings, layer)
    return validate(settings)


def write_resolved(config: Config, path: Path) -> None:
    """Write all settings, defaults filled in, as the YAML file that the commands read; a file that already says the same is left alone."""
    head = "# Written by the workflow: all settings of this run, defaults filled in.\n"
    text = head + yaml.safe_dump(config.model_dump(mode="json"), sort_keys=False)
    if path.exists() and path.read_text(encoding="utf-8") == text:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.part")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


def json_schema() -> dict[str, Any]:
    """The JSON schema of the configuration."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Config.model_json_schema()}


def joint_range(agent: AgentConfig) -> float:
    """Stops of the arm joints, rad; infinite for none."""
    return (
        math.inf if agent.joint_range_degrees is None else math.radians(agent.joint_range_degrees)
    )
