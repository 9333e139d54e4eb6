"""Hashes of files and of settings."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any


def sha256(path: Path) -> str:
    """SHA-256 of a file's content, hexadecimal. Raises OSError."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def digest(*values: Any) -> str:
    """Sixteen hexadecimal digits of the SHA-256 of JSON values.

    Objects with a method ``model_dump`` (pydantic models) are hashed by their fields. Fields named
    ``*_per_job`` are left out: they say how work is cut into jobs and change no result.
    """
    text = json.dumps(values, default=lambda model: _drop_per_job(model.model_dump(mode="json")))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _drop_per_job(value: Any) -> Any:
    if isinstance(value, dict):
        fields = {key: v for key, v in value.items() if not key.endswith("_per_job")}
        return {key: _drop_per_job(field) for key, field in fields.items()}
    return [_drop_per_job(item) for item in value] if isinstance(value, list) else value
