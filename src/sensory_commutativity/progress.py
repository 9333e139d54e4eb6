"""Progress bars, shown only on a terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from tqdm import tqdm

T = TypeVar("T")


def progress(items: Iterable[T], description: str, unit: str) -> Iterable[T]:
    """Iterate over `items`, with a bar on standard error if that is a terminal."""
    return tqdm(items, desc=description, unit=unit, disable=None, leave=False)
