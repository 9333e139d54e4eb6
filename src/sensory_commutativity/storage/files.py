"""Opening files from elsewhere: regular files of a bounded size, and names that are safe to print.

A device or a pipe in place of a file would block for ever or never end.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from ..errors import UserError


def check_regular_file(
    path: Path, error: type[UserError], remedy: str, max_bytes: int | None = None
) -> None:
    """Check that `path` is a regular file, or a link to one, of at most `max_bytes`.

    Raises
    ------
    error
        In one line: the file, what is wrong, and `remedy`. A missing file is not an error here,
        because every reader has a message of its own for it.
    """
    try:
        status = os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or problem
        raise error(f"{path}: cannot be read ({reason}); {remedy}") from None
    if not stat.S_ISREG(status.st_mode):
        kind = describe_mode(status.st_mode)
        raise error(f"{path}: cannot be read: it is {kind}, not a regular file; {remedy}")
    if max_bytes is not None and status.st_size > max_bytes:
        raise error(
            f"{path}: has {status.st_size:,} bytes, and files of more than {max_bytes:,} bytes "
            f"are not read; {remedy}"
        )


def read_bounded(path: Path, error: type[UserError], remedy: str, max_bytes: int) -> bytes:
    """The content of a regular file of at most `max_bytes`. Raises `error`, or OSError."""
    check_regular_file(path, error, remedy, max_bytes)
    with path.open("rb") as file:
        content = file.read(max_bytes + 1)
    if len(content) > max_bytes:  # files in /proc have no size
        raise error(f"{path}: has more than {max_bytes:,} bytes; {remedy}")
    return content


def describe_mode(mode: int) -> str:
    """What a file is by its mode: "a folder", "a pipe", ..."""
    kinds = (
        (stat.S_ISDIR, "a folder"),
        (stat.S_ISFIFO, "a pipe"),
        (stat.S_ISSOCK, "a socket"),
        (stat.S_ISCHR, "a device"),
        (stat.S_ISBLK, "a device"),
        (stat.S_ISLNK, "a link"),
    )
    return next((name for test, name in kinds if test(mode)), "something else")


def printable(text: str) -> str:
    """`text` on one line, with every character that a terminal may act on written as an escape.

    That is control characters, newlines included, and those that change the direction of writing.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
