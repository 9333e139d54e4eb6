"""Provenance of a study's files: which configuration, seed, code and platform produced them."""

from __future__ import annotations

from ..storage.provenance import environment
from .config import Config


def provenance(config: Config) -> dict[str, str]:
    """Profile, SHA-256 of the configuration, root seed, and the environment."""
    return {
        "profile": config.profile,
        "config_sha256": config.digest(),
        "root_seed": str(config.seed),
        **environment(),
    }
