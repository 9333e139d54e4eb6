"""Provenance of a study's files: which configuration, seed, code and platform produced them, and
from which files."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar

from ..storage.provenance import environment
from .config import Config

INPUTS = "inputs"
"""Metadata key of the files that a file was computed from, as JSON: name -> hash of the content."""
_inputs: ContextVar[Mapping[str, str] | None] = ContextVar("inputs", default=None)


@contextmanager
def computed_from(inputs: Mapping[str, str]) -> Iterator[None]:
    """Within the block, :func:`provenance` names these inputs: name -> hash of the content."""
    token = _inputs.set(dict(inputs))
    try:
        yield
    finally:
        _inputs.reset(token)


def provenance(config: Config) -> dict[str, str]:
    """Profile, SHA-256 of the configuration, root seed, the environment, and the inputs."""
    inputs = _inputs.get()
    return {
        "profile": config.profile,
        "config_sha256": config.digest(),
        "root_seed": str(config.seed),
        **environment(),
        **({INPUTS: json.dumps(inputs, sort_keys=True)} if inputs else {}),
    }
