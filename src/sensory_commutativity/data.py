"""Files that belong to the package: robots, scenes, configuration, and a trained predictor.

In an installed package they lie in its folder ``files``; in a clone of the repository, where they
come from, they lie in the folders named below.
"""

from __future__ import annotations

from pathlib import Path

from .errors import UserError

FOLDERS = {
    "config": "config",
    "predictors": "results/paper/models/masks",
}
"""Folder in the package -> folder in the repository; as in pyproject.toml."""


def data_file(*parts: str) -> Path:
    """Path of a file of the package, e.g. ``data_file("config", "robots", "fetch.yaml")``.

    Raises
    ------
    UserError
        If there is no such file.
    """
    installed = Path(__file__).parent / "files"
    folder, *rest = parts
    root = installed / folder
    if not root.is_dir():
        root = Path(__file__).resolve().parents[2] / FOLDERS[folder]
    path = root.joinpath(*rest)
    if not path.exists():
        raise UserError(f"{path}: is missing from the installed package; install it again")
    return path


def data_names(*parts: str) -> list[str]:
    """Names of the YAML files in a folder of the package, without the suffix."""
    return sorted(path.stem for path in data_file(*parts).glob("*.yaml"))
