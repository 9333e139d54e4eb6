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

    A :class:`~sensory_commutativity.storage.settings.Section` counts with those of its settings
    that affect results.
    """
    text = json.dumps(values, default=lambda section: section.settings_that_affect_results())
    return hashlib.sha256(text.encode()).hexdigest()[:16]
