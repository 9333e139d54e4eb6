"""Files that a URDF or a scene names: where they are, and whether they may be opened.

Files come from elsewhere, so they are only read, and only if they are regular files of a size
that somebody would write.
"""

from __future__ import annotations

import difflib
import importlib.util
import os
import stat
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

PACKAGE_FOLDERS = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH")
"""Environment variables of ROS 1 and 2 that list the folders of packages."""
MODEL_FOLDERS = ("GAZEBO_MODEL_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
"""Environment variables of Gazebo that list the folders of models."""
MAX_SEARCHED = 2_000
"""Folders in which a package.xml is looked for, at most; chosen: large workspaces have hundreds."""
MAX_DEPTH = 3
"""Levels of folders below an entry of PACKAGE_FOLDERS; chosen: workspace/src/repository/package."""
MAX_NAME = 1_000
"""Characters of a file's name; chosen: Linux takes 4096."""
POINTERS = (
    (b"version https://git-lfs", "is a Git LFS pointer, not the file itself; run git lfs pull"),
    (b"/annex/objects/", "is a git-annex pointer, not the file itself; run git annex get"),
    (b"<!doctype html", "is a web page, not the file itself; download the raw file"),
    (b"<html", "is a web page, not the file itself; download the raw file"),
    (b"pk\x03\x04", "is a ZIP archive; unpack it"),
    (b"\x1f\x8b", "is compressed by gzip; unpack it"),
)
"""Beginnings of files that stand in for others, in lower case, and what to do."""


class FileError(ValueError):
    """A file is not there or must not be opened; the message continues "the file ..."."""


def check_file(path: Path, max_bytes: int) -> bytes:
    """Check that a file may be read, and return its first 512 bytes.

    Raises
    ------
    FileError
        It is no regular file, empty, too large, or stands in for another.
    """
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise FileError("is not a regular file; name a file")
        if status.st_size == 0:
            raise FileError("is empty (0 bytes); fetch or export it again")
        if status.st_size > max_bytes:
            raise FileError(
                f"has {status.st_size:,} bytes, more than {max_bytes:,}; give a smaller file"
            )
        with path.open("rb") as file:
            head = file.read(512)
    except (OSError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise FileError(f"cannot be opened ({reason}); check the path") from None
    start = head.lstrip(b"\xef\xbb\xbf \r\n\t").lower()
    for beginning, what in POINTERS:
        if start.startswith(beginning):
            raise FileError(what)
    return head


def find_file(name: str, folder: Path) -> Path | None:
    """As :func:`locate`, but None if there is no such file."""
    try:
        return locate(name, folder)
    except FileError:
        return None


def locate(name: str, folder: Path) -> Path:
    """Return the path of the file that a file in `folder` calls `name`.

    ``package://NAME/REST`` is searched for in a folder NAME that is inside `folder` or one of its
    ancestors, or is one of them; in packages whose package.xml says NAME, in and beside these
    folders and below those of PACKAGE_FOLDERS; and in the installed Python package NAME.
    ``model://NAME/REST`` is searched for in the same ancestors and in MODEL_FOLDERS.

    Raises
    ------
    FileError
        It says where the file was looked for, what is there instead, and the remedy.
    """
    name = name.strip()
    if len(name) > MAX_NAME or "\0" in name:
        raise FileError("does not exist (no file can have this name); correct it")
    if "$(" in name or "${" in name:
        raise FileError(
            "contains an expression of xacro that was not expanded; run xacro FILE > robot.urdf"
        )
    scheme, separator, rest = name.partition("://")
    if not separator:
        return _choose([folder / name, *_spellings(folder, name)], folder)
    if scheme == "package":
        return _locate_package(rest, folder)
    if scheme == "model":
        return _locate_model(rest, folder)
    if scheme == "file":
        return _choose([folder / rest, folder / unquote(rest)], folder)
    if scheme in ("http", "https", "ftp"):
        raise FileError(
            "does not exist here: files are not fetched from the web; download it and write its "
            "path relative to this file"
        )
    raise FileError(
        f"does not exist: {scheme}:// is not known; write a path relative to this file, or "
        "package://NAME/PATH"
    )


def _spellings(folder: Path, name: str) -> Iterator[Path]:
    """Other ways to read the same name: of Windows, as a URL, from the folders above."""
    if "\\" in name:
        yield folder / name.replace("\\", "/")
    if "%" in name:
        yield folder / unquote(name)
    if "/" in name.replace("\\", "/") and not name.startswith(("/", ".")):
        # PyBullet has search paths, and the folders urdf and meshes are often beside each other.
        for parent in list(folder.resolve().parents)[:2]:
            yield parent / name.replace("\\", "/")


def _locate_package(rest: str, folder: Path) -> Path:
    package, _, inner = rest.replace("\\", "/").lstrip("/").partition("/")
    inner = inner.lstrip("/")
    ancestors = [folder, *folder.resolve().parents]
    roots = [
        *(ancestor / package for ancestor in ancestors),
        *(ancestor for ancestor in ancestors if ancestor.resolve().name == package),
        *_find_python_package(package),
    ]
    found = _first([root / inner for root in roots])
    if found is not None:
        return found
    further = [*_packages_called(package, ancestors), *_ros_packages(package)]
    further += ancestors[:MAX_DEPTH]  # the package's folder may have another name
    try:
        return _choose([root / inner for root in (*roots, *further)], folder)
    except FileError as error:
        known = [root for root in (*roots, *further[:-MAX_DEPTH]) if root.is_dir()]
        if known:
            raise
        looked = ", ".join(["the folders above it", *_set_variables(PACKAGE_FOLDERS)])
        raise FileError(
            f"does not exist: no folder and no installed package is called {package!r} (looked in "
            f"{looked}); put it beside the file, set ROS_PACKAGE_PATH, or install the package it "
            "is in"
        ) from error


def _locate_model(rest: str, folder: Path) -> Path:
    folders = [folder, *folder.resolve().parents, *_variable_folders(MODEL_FOLDERS)]
    candidates = [parent / rest for parent in folders]
    candidates += [parent / "models" / rest for parent in folders]
    try:
        return _choose(candidates, folder)
    except FileError:
        raise FileError(
            "does not exist: model:// is Gazebo's way to name a file; set GAZEBO_MODEL_PATH to "
            "the folder of the models, or write a path relative to this file"
        ) from None


def _first(candidates: list[Path]) -> Path | None:
    for candidate in candidates:
        try:
            if candidate.is_file():
                return candidate
        except (OSError, ValueError):  # the name is too long for a file, or has a zero byte
            continue
    return None


def _choose(candidates: list[Path], folder: Path) -> Path:
    """Return the first that is a file. Raises FileError with what is there instead."""
    found = _first(candidates)
    if found is not None:
        return found
    for candidate in candidates:
        try:
            if candidate.exists():
                raise FileError(f"is not a regular file ({candidate}); name a file")
            near = _near_miss(candidate)
        except OSError:
            continue
        if near is not None:
            shown = os.path.relpath(near, folder) if near.is_relative_to(folder) else near
            raise FileError(f"does not exist, but {shown} does; correct the name")
    raise FileError(
        f"does not exist (looked for {candidates[0]}); put it there, or correct the name"
    )


def _near_miss(path: Path) -> Path | None:
    """A file whose name differs in case only, or slightly."""
    known = path
    missing: list[str] = []
    while not known.is_dir():
        if known == known.parent:
            return None
        missing.insert(0, known.name)
        known = known.parent
    for i, name in enumerate(missing):
        names = [entry.name for entry in os.scandir(known)][:MAX_SEARCHED]
        same = [one for one in names if one.lower() == name.lower()]
        if not same and i == len(missing) - 1:
            same = difflib.get_close_matches(name, names, 1, 0.75)
        if not same:
            return None
        known = known / same[0]
    return known if known.is_file() else None


def portable_name(path: Path, folder: Path) -> str:
    """What a file in `folder` calls `path`: package://NAME/REST in an installed package."""
    path = path.resolve()
    for parent in path.parents:
        home = parent.parent
        if home.name in ("site-packages", "dist-packages") or home.match("cmeel.prefix/share"):
            if any(parent == found.resolve() for found in _find_python_package(parent.name)):
                return f"package://{parent.name}/{path.relative_to(parent).as_posix()}"
            break
    return Path(os.path.relpath(path, folder.resolve())).as_posix()


# ---- packages --------------------------------------------------------------------------------


def _find_python_package(package: str) -> list[Path]:
    """Return the folders of an installed Python package without importing it."""
    try:
        spec = importlib.util.find_spec(package) if package.isidentifier() else None
    except (ValueError, ImportError):  # __main__
        spec = None
    locations = spec.submodule_search_locations if spec else None
    # Wheels of cmeel hold ROS packages in a folder of their own.
    shared = [Path(entry) / "cmeel.prefix" / "share" / package for entry in sys.path if entry]
    return [Path(location) for location in locations or []] + [
        folder for folder in shared if folder.is_dir()
    ]


def _set_variables(names: tuple[str, ...]) -> list[str]:
    return [name for name in names if os.environ.get(name)]


def _variable_folders(names: tuple[str, ...]) -> list[Path]:
    texts = [os.environ.get(name, "") for name in names]
    return [Path(part) for text in texts for part in text.split(os.pathsep) if part]


def _packages_called(package: str, ancestors: list[Path]) -> Iterator[Path]:
    """Folders among and beside `ancestors` whose package.xml gives this name."""
    for ancestor in ancestors[:6]:
        if _package_name(ancestor) == package:
            yield ancestor
        yield from (child for child in _subfolders(ancestor) if _package_name(child) == package)


def _ros_packages(package: str) -> Iterator[Path]:
    """The folders of a package below those of PACKAGE_FOLDERS."""
    for entry in _variable_folders(PACKAGE_FOLDERS):
        yield entry / package
        yield entry / "share" / package
        if entry.name == package:
            yield entry
        searched, level = 0, [entry]
        for _ in range(MAX_DEPTH + 1):
            below: list[Path] = []
            for folder in level:
                searched += 1
                if searched > MAX_SEARCHED:
                    return
                if folder.name == package or _package_name(folder) == package:
                    yield folder
                below += _subfolders(folder)
            level = below


def _subfolders(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            return sorted(
                Path(entry.path)
                for entry in entries
                if entry.is_dir() and not entry.name.startswith(".")
            )[:MAX_SEARCHED]
    except OSError:
        return []


def _package_name(folder: Path) -> str | None:
    """What the package.xml of a folder gives as its name."""
    path = folder / "package.xml"
    try:
        if not path.is_file() or path.stat().st_size > 100_000:
            return None
        content = path.read_bytes()
        if b"<!ENTITY" in content:
            return None
        return (ET.fromstring(content).findtext("name") or "").strip()
    except (OSError, ValueError, ET.ParseError):
        return None
