"""Links of the pages: valid on the forge, where the repository is browsed, and on the site.

A page links to a file of the repository by its relative path. On the site, pages keep their places
below ``docs/``; other files that a page links to become part of the site below ``repository/``:
Markdown as a page, pictures as they are, other text as a page with a listing. Folders are no link.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Callable
from pathlib import Path, PurePosixPath

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s]+)\)")
FENCE = re.compile(r"^(`{3,}|~{3,}).*?^\1[ \t]*$", re.MULTILINE | re.DOTALL)
PICTURES = {".gif", ".jpg", ".png", ".svg"}
HOME = {"README.md": "index.md", "docs": "index.md"}


def site_path(target: str) -> str:
    """Path of a file of the repository below the site's source folder.

    >>> site_path("docs/tutorials/a.ipynb"), site_path("config/README.md")
    ('tutorials/a.md', 'repository/config/README.md')
    >>> site_path("src/a.py"), site_path("README.md")
    ('repository/src/a.py.md', 'index.md')
    """
    if target in HOME:
        return HOME[target]
    inside = target.startswith("docs/")
    path = target.removeprefix("docs/") if inside else f"repository/{target}"
    suffix = PurePosixPath(path).suffix.lower()
    if suffix == ".ipynb":
        return path.removesuffix(".ipynb") + ".md"
    if inside or suffix == ".md" or suffix in PICTURES:
        return path
    return f"{path}.md"


def relative_targets(markdown: str, page: str) -> list[str]:
    """Files and folders of the repository to which the page `page` links, in order."""
    targets: list[str] = []

    def note(match: re.Match[str]) -> str:
        target = _target(match[3], page)
        if target is not None:
            targets.append(target[0])
        return match[0]

    _outside_fences(markdown, lambda text: LINK.sub(note, text))
    return targets


def rewrite(markdown: str, page: str, root: Path) -> str:
    """The page with links that are valid on the site; `page` is its path in the repository."""
    here = posixpath.dirname(site_path(page))

    def replace(match: re.Match[str]) -> str:
        bang, text, link = match[1], rewrite_text(match[2]), match[3]
        found = _target(link, page)
        if found is None:
            return f"{bang}[{text}]({link})"
        target, anchor = found
        if target not in HOME and (root / target).is_dir():
            return text
        return f"{bang}[{text}]({posixpath.relpath(site_path(target), here or '.')}{anchor})"

    def rewrite_text(text: str) -> str:
        return LINK.sub(replace, text)  # a picture that is a link

    return _outside_fences(markdown, lambda text: LINK.sub(replace, text))


def _target(link: str, page: str) -> tuple[str, str] | None:
    """Path in the repository and anchor of a relative link; None for any other."""
    path, hash_, anchor = link.partition("#")
    if not path or "://" in link or link.startswith(("mailto:", "/")):
        return None
    target = posixpath.normpath(posixpath.join(posixpath.dirname(page), path))
    return target, hash_ + anchor


def _outside_fences(markdown: str, change: Callable[[str], str]) -> str:
    """`change` applied to all of a page but its blocks of code."""
    parts, end = [], 0
    for fence in FENCE.finditer(markdown):
        parts += [change(markdown[end : fence.start()]), fence[0]]
        end = fence.end()
    return "".join([*parts, change(markdown[end:])])
