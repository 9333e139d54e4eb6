"""Files that hold tensors: what a killed run goes on from, and what it leaves.

A file begins with the SHA-256 of the rest: torch reads over some damage, and raises whatever the bytes lead it to over the rest. The bytes depend on
what is saved alone, not on the file's name.
"""

from __future__ import annotations

import hashlib
import io
from pathlib import Path
from typing import Any

import torch

from ..errors import UserError
from .atomic import atomic_write

DIGEST = 32  # bytes


class CheckpointError(UserError):
    """A checkpoint or a model cannot be used."""


def save_state(path: Path, state: dict[str, Any]) -> None:
    """Write tensors, numbers, strings, lists and mappings of them; the file gets its name only when it is whole."""
    payload = io.BytesIO()
    torch.save(state, payload)
    with atomic_write(path) as temporary:
        temporary.write_bytes(hashlib.sha256(payload.getvalue()).digest() + payload.getvalue())


def load_state(path: Path, remedy: str) -> dict[str, Any]:
    """Read what :func:`save_state` wrote. Raises CheckpointError, with the remedy, when the file is missing, damaged, or holds anything else.

    The hash tells damage, not who wrote the file: torch must refuse what would run code.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise CheckpointError(f"{path}: there is no such file; {remedy}") from None
    digest, payload = data[:DIGEST], data[DIGEST:]
    if hashlib.sha256(payload).digest() != digest:
        raise CheckpointError(f"{path}: a damaged file; delete it, and {remedy}")
    try:
        return torch.load(io.BytesIO(payload), map_location="cpu", weights_only=True)
    except (
        Exception
    ) as error:  # whatever torch raises for bytes that it did not write, or will not read
        raise CheckpointError(
            f"{path}: holds more than tensors, numbers and text ({type(error).__name__}); delete it, and {remedy}"
        ) from None


class Checkpoint:
    """The checkpoint of the run that will write `out`.

    Parameters
    ----------
    out : Path
    settings : str
        All that the run depends on. A checkpoint of other settings is another run's: it is left alone, and :meth:`forget` takes it away in the end.
    """

    def __init__(self, out: Path, settings: str):
        self.out = out
        self.path = out.with_name(
            f".{out.name}.{hashlib.sha256(settings.encode()).hexdigest()[:16]}.checkpoint"
        )

    def load(self) -> dict[str, Any] | None:
        """What was saved last, or None. Raises CheckpointError when the file is damaged."""
        return load_state(self.path, "the run starts anew") if self.path.exists() else None

    def save(self, state: dict[str, Any]) -> None:
        """Save what :func:`save_state` can."""
        save_state(self.path, state)

    def forget(self) -> None:
        """Remove all checkpoints of this run, now that it has written what it should."""
        for path in self.out.parent.glob(f".{self.out.name}.*.checkpoint"):
            path.unlink(missing_ok=True)
