"""Progress bars, shown only on a terminal, and not at all after :func:`hide`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

from tqdm import tqdm

T = TypeVar("T")
_hidden = False


def hide() -> None:
    """Show no progress bar from now on."""
    global _hidden
    _hidden = True


def progress(items: Iterable[T], description: str, unit: str) -> Iterable[T]:
    """Iterate over `items`, with a bar on standard error if that is a terminal."""
    return tqdm(items, desc=description, unit=unit, disable=_hidden or None, leave=False)


def progress_bar(
    total: int, done: int, description: str, unit: str, shown: bool | None = None
) -> Any:
    """A bar to be used in a ``with`` statement and moved by its method ``update()``.

    Parameters
    ----------
    total, done : int
        Units of work in all, and finished before.
    description, unit : str
    shown : bool, optional
        By default only on a terminal.
    """
    disable = _hidden or None if shown is None else not shown
    return tqdm(
        total=total, initial=done, desc=description, unit=unit, disable=disable, leave=False
    )
