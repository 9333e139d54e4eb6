"""A hash inside a file that it covers, for formats that have none: Parquet, GIF, PDF and JSON.

The seal is a line of text with 64 digits. It is written with zeros in their place, the file is
hashed, and the zeros are replaced.
"""

from __future__ import annotations

import hashlib
import re

SEAL = f"sealed-by-sha256:{'0' * 64}"
"""Text to be part of a file before it is sealed."""
SEAL_KEY = "seal"
"""Key of the seal in JSON; the first, as the comment of a GIF is cut every 255 bytes."""
_SEAL = re.compile(rb"sealed-by-sha256:(.{64})", re.DOTALL)
_TRACES = (b"sealed-by", b"sha256:")
"""What is left of a damaged seal."""


def seal(data: bytes) -> bytes:
    """Replace the zeros of the one SEAL in `data`. Raises ValueError if there is another number."""
    if data.count(SEAL.encode()) != 1:
        raise ValueError(f"expected one seal, found {data.count(SEAL.encode())}")
    digest = hashlib.sha256(data).hexdigest()
    return data.replace(SEAL.encode(), SEAL.replace("0" * 64, digest).encode())


def is_intact(data: bytes) -> bool | None:
    """Whether sealed `data` are as they were; None if they have no seal."""
    match = _SEAL.search(data)
    if match is None:
        return False if any(trace in data for trace in _TRACES) else None
    return hashlib.sha256(unseal(data)).hexdigest().encode() == match[1]


def unseal(data: bytes) -> bytes:
    """`data` with zeros in place of the digits of the seal; unchanged if they have none."""
    match = _SEAL.search(data)
    if match is None:
        return data
    start, stop = match.span(1)
    return data[:start] + b"0" * 64 + data[stop:]
