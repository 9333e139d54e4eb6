"""Progress bars, shown only when a person watches."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from tqdm import tqdm

T = TypeVar("T")


def progress(things: Iterable[T], what: str, unit: str) -> Iterable[T]:
    """Go through `things`, with a bar on standard error if that is a terminal."""
    return tqdm(things, desc=what, unit=unit, disable=None, leave=False)
