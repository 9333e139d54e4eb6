"""Paths in the configuration: written relative to the file that holds them.

In memory they are relative to the current folder where they lie below it, so that the configuration
of a clone is the same wherever the clone lies, and absolute otherwise.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

PATHS = (
    ("apartment", "robots", "*", "description"),
    ("apartment", "scenes", "*", "file"),
    ("apartment", "weights"),
    ("gallery", "robots", "*", "description"),
    ("gallery", "scenes", "*", "file"),
)
"""Keys whose values are paths; ``*`` stands for any name."""


def resolve_paths(settings: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return settings whose paths, relative to `folder`, are relative to the current folder."""
    return _replace(settings, lambda _, path: _from_here(folder / path))


def resolve_merged_paths(
    settings: dict[str, Any], layers: Sequence[tuple[dict[str, Any], Path]]
) -> dict[str, Any]:
    """As :func:`resolve_paths`, for settings that others have merged from several files.

    Parameters
    ----------
    settings : dict
    layers : sequence of (dict, Path)
        Content of each file and its folder, the last taking precedence. A path belongs to the last
        file that holds it; one that no file holds is relative to the current folder.
    """
    written = [(dict(_iterate(layer)), folder) for layer, folder in layers]

    def resolve(key: tuple[str, ...], path: str) -> str:
        folders = [folder for layer, folder in written if layer.get(key) == path]
        return _from_here(folders[-1] / path) if folders else path

    return _replace(settings, resolve)


def relative_paths(settings: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return settings whose paths are relative to `folder`, for a file that is written there.

    Paths that are absolute, as those outside the current folder are, stay absolute.
    """

    def relative(key: tuple[str, ...], path: str) -> str:
        return path if os.path.isabs(path) else Path(os.path.relpath(path, folder)).as_posix()

    return _replace(settings, relative)


def _from_here(path: Path) -> str:
    absolute, here = os.path.abspath(path), os.getcwd()
    below = absolute.startswith(here.rstrip(os.sep) + os.sep)
    return Path(os.path.relpath(absolute) if below else absolute).as_posix()


def _replace(
    settings: dict[str, Any], change: Callable[[tuple[str, ...], str], str]
) -> dict[str, Any]:
    """A copy of `settings` in which every path is what `change` makes of its key and value."""

    def copy(node: Any, key: tuple[str, ...]) -> Any:
        if isinstance(node, dict):
            return {name: copy(value, (*key, str(name))) for name, value in node.items()}
        return change(key, node) if isinstance(node, str) and node and _is_path(key) else node

    return copy(settings, ())


def _iterate(node: Any, key: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], str]]:
    """Key and value of every path."""
    if isinstance(node, dict):
        for name, value in node.items():
            yield from _iterate(value, (*key, str(name)))
    elif isinstance(node, str) and _is_path(key):
        yield key, node


def _is_path(key: tuple[str, ...]) -> bool:
    return any(
        len(key) == len(path) and all(b in ("*", a) for a, b in zip(key, path, strict=True))
        for path in PATHS
    )
