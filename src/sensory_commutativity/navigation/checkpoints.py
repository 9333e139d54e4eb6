"""What a killed run goes on from: one file per run, written whole, beside what the run will write.

The file begins with the SHA-256 of the rest: torch reads over some damage, and raises whatever the bytes lead it to over the rest.
"""

from __future__ import annotations

import hashlib
import io
from pathlib import Path
from typing import Any

import torch

from ..errors import UserError
from ..tables import written_whole

DIGEST = 32  # bytes


class CheckpointError(UserError):
    """A checkpoint cannot be used."""


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
        self.path = out.with_name(f".{out.name}.{hashlib.sha256(settings.encode()).hexdigest()[:16]}.checkpoint")

    def load(self) -> dict[str, Any] | None:
        """What was saved last, or None. Raises CheckpointError when the file is damaged."""
        if not self.path.exists():
            return None
        data = self.path.read_bytes()
        digest, payload = data[:DIGEST], data[DIGEST:]
        if hashlib.sha256(payload).digest() != digest:
            raise CheckpointError(f"{self.path}: a damaged checkpoint; delete it, and the run starts anew")
        return torch.load(io.BytesIO(payload), map_location="cpu", weights_only=True)

    def save(self, state: dict[str, Any]) -> None:
        """Save tensors, numbers, strings, lists and mappings of them."""
        payload = io.BytesIO()
        torch.save(state, payload)
        with written_whole(self.path) as temporary:
            temporary.write_bytes(hashlib.sha256(payload.getvalue()).digest() + payload.getvalue())

    def forget(self) -> None:
        """Remove all checkpoints of this run, now that it has written what it should."""
        for path in self.out.parent.glob(f".{self.out.name}.*.checkpoint"):
            path.unlink(missing_ok=True)
