"""The whole configuration: what all parts share, and the parts."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Annotated

from pydantic import Field, StringConstraints

from .flatland import FlatlandConfig
from .section import Name, Section


class Config(Section):
    """The whole configuration."""

    profile: Name = Field(description="Name of the run; results lie in a folder of this name.")
    results: Annotated[str, StringConstraints(pattern=r"^[^{}~*?\x00-\x1f]+$")] = Field(
        "results", max_length=200, description="Folder that holds the results of all profiles; no braces, wildcards or ~ in its name."
    )
    seed: int = Field(ge=0, lt=2**63, description="The root seed; everything random follows from it.")
    flatland: FlatlandConfig

    @property
    def folder(self) -> Path:
        """Where this run's results lie."""
        return Path(self.results) / self.profile

    def digest(self) -> str:
        """SHA-256 of all settings, hexadecimal; the same however the file is written."""
        return hashlib.sha256(json.dumps(self.model_dump(mode="json"), sort_keys=True).encode()).hexdigest()
