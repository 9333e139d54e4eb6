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
from .files import read_bounded

_HASH_BYTES = 32
MAX_BYTES = 500_000_000
"""Size of a file; chosen: a hundred times that of our largest model."""


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
        data = read_bounded(path, CheckpointError, remedy, MAX_BYTES)
    except FileNotFoundError:
        raise CheckpointError(f"{path}: there is no such file; {remedy}") from None
    except OSError as error:
        raise CheckpointError(f"{path}: cannot be read ({error.strerror}); {remedy}") from None
    expected_hash, payload = data[:_HASH_BYTES], data[_HASH_BYTES:]
    if hashlib.sha256(payload).digest() != expected_hash:
        raise CheckpointError(f"{path}: a damaged file; delete it, and {remedy}")
    try:
        state = torch.load(io.BytesIO(payload), map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises all kinds for bytes that it did not write
        raise CheckpointError(
            f"{path}: holds more than tensors, numbers and text ({type(error).__name__}); "
            f"delete it, and {remedy}"
        ) from None
    if not isinstance(state, dict):
        raise CheckpointError(f"{path}: holds no model; delete it, and {remedy}")
    problem = _find_oversized(state, len(payload))
    if problem:
        raise CheckpointError(f"{path}: {problem}; delete it, and {remedy}")
    return state


def _find_oversized(state: Any, size: int) -> str:
    """What is wrong with the tensors of a file of `size` bytes, or "".

    A tensor can stand for more numbers than are stored, if its strides are 0.
    """
    total, stack = 0, [state]
    while stack:
        value = stack.pop()
        if isinstance(value, dict):
            stack += [*value.keys(), *value.values()]
        elif isinstance(value, list | tuple):
            stack += value
        elif isinstance(value, torch.Tensor):
            if value.layout != torch.strided or value.device.type != "cpu":
                return f"holds a tensor of the layout {value.layout}"
            total += value.numel() * value.element_size()
    return f"declares {total:,} bytes of numbers, more than it holds" if total > 2 * size else ""


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
        self._settings_hash = hashlib.sha256(settings.encode()).hexdigest()
        self.path = out.with_name(f".{out.name}.{self._settings_hash[:16]}.checkpoint")

    def load(self) -> dict[str, Any] | None:
        """Return the state that was saved last, or None.

        Raises
        ------
        CheckpointError
            If the file is damaged, or if it is that of another run under this name.
        """
        if not self.path.exists():
            return None
        saved = load_state(self.path, "the run starts over")
        if saved.get("settings_sha256") != self._settings_hash or "state" not in saved:
            raise CheckpointError(
                f"{self.path}: is the checkpoint of another run; delete it, and the run starts over"
            )
        return saved["state"]

    def save(self, state: dict[str, Any]) -> None:
        """Save a state; see :func:`save_state`."""
        save_state(self.path, {"settings_sha256": self._settings_hash, "state": state})

    def remove(self) -> None:
        """Delete all checkpoints for `out`, once it has been written."""
        for path in self.out.parent.glob(f".{self.out.name}.*.checkpoint"):
            path.unlink(missing_ok=True)
