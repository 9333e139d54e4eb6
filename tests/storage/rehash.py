"""Give a changed file of arrays the hash of its content, as somebody who forges one would."""

from __future__ import annotations

import hashlib
from pathlib import Path

from sensory_commutativity.storage.arrays import USER_BLOCK


def rehash(path: Path) -> None:
    """Replace the hash in the user block by that of the rest of the file."""
    rest = path.read_bytes()[USER_BLOCK:]
    header = f"sensory-commutativity arrays; sha256 of the rest: {hashlib.sha256(rest).hexdigest()}"
    path.write_bytes(f"{header}\n".encode().ljust(USER_BLOCK, b"\0") + rest)
