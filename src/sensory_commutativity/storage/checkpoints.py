"""Files of tensors: checkpoints, from which a killed run resumes, and trained models.

A file starts with the SHA-256 of the rest, because torch does not notice some damage and raises
arbitrary exceptions for other damage. The bytes depend on the saved state alone, not on the name
of the file.
"""

from __future__ import annotations

import hashlib
import io
from pathlib import Path
from typing import Any

import torch

from ..errors import UserError
from .atomic import atomic_write

_HASH_BYTES = 32


class CheckpointError(UserError):
    """A checkpoint or a model cannot be used."""


def save_state(path: Path, state: dict[str, Any]) -> None:
    """Write tensors, numbers, strings, and lists and dicts of them, atomically."""
    payload = io.BytesIO()
    torch.save(state, payload)
    with atomic_write(path) as temporary:
        temporary.write_bytes(hashlib.sha256(payload.getvalue()).digest() + payload.getvalue())


def load_state(path: Path, remedy: str) -> dict[str, Any]:
    """Read what :func:`save_state` wrote, on the CPU.

    The hash detects damage, not who wrote the file, so torch must refuse whatever would execute
    code.

    Raises
    ------
    CheckpointError
        With `remedy`, if the file is missing, damaged, or holds anything else.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise CheckpointError(f"{path}: there is no such file; {remedy}") from None
    expected_hash, payload = data[:_HASH_BYTES], data[_HASH_BYTES:]
    if hashlib.sha256(payload).digest() != expected_hash:
        raise CheckpointError(f"{path}: a damaged file; delete it, and {remedy}")
    try:
        return torch.load(io.BytesIO(payload), map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises all kinds for bytes that it did not write
        raise CheckpointError(
            f"{path}: holds more than tensors, numbers and text ({type(error).__name__}); "
            f"delete it, and {remedy}"
        ) from None


class Checkpoint:
    """The checkpoint of the run that will write the file `out`.

    Parameters
    ----------
    out : Path
    settings : str
        Everything that the run depends on. A checkpoint with other settings belongs to another
        run: it is neither read nor overwritten, but :meth:`remove` deletes it, too.
    """

    def __init__(self, out: Path, settings: str):
        self.out = out
        settings_hash = hashlib.sha256(settings.encode()).hexdigest()[:16]
        self.path = out.with_name(f".{out.name}.{settings_hash}.checkpoint")

    def load(self) -> dict[str, Any] | None:
        """Return the state that was saved last, or None.

        Raises
        ------
        CheckpointError
            If the file is damaged.
        """
        return load_state(self.path, "the run starts over") if self.path.exists() else None

    def save(self, state: dict[str, Any]) -> None:
        """Save a state; see :func:`save_state`."""
        save_state(self.path, state)

    def remove(self) -> None:
        """Delete all checkpoints for `out`, once it has been written."""
        for path in self.out.parent.glob(f".{self.out.name}.*.checkpoint"):
            path.unlink(missing_ok=True)
