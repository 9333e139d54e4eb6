"""The hook of MkDocs: pages that are made when the site is built, links, and the navigation."""

from __future__ import annotations

import fnmatch
import html
import re
import sys
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

sys.path.insert(0, str(Path(__file__).parent))  # MkDocs imports this file alone

import links
import notebooks
import reference
import results

ROOT = Path(__file__).resolve().parents[2]
LISTINGS = {".json": "json", ".py": "python", ".smk": "python", ".toml": "toml", ".yaml": "yaml"}
FALLBACK = "How-to"
"""Section of the navigation to which pages are added that it does not name."""
LARGEST = 200_000
"""Bytes of a file that is shown as a listing; chosen: five times the longest one so far."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are made here, and the files to which pages link."""
    made = reference.reference_pages()
    index = files.get_file_from_path("reference/index.md")
    if index is not None:
        files.remove(index)
        made["reference/index.md"] = _with_contents(index.content_string, made)
    pictures: dict[str, bytes] = {}
    for notebook in sorted((ROOT / "docs").rglob("*.ipynb")):
        if notebook.parent.name != ".ipynb_checkpoints":
            page = notebook.relative_to(ROOT / "docs").with_suffix(".md")
            made[page.as_posix()], own = notebooks.notebook_page(notebook)
            pictures |= {(page.parent / name).as_posix(): data for name, data in own.items()}
    for path, content in {**made, **pictures}.items():
        files.append(File.generated(config, path, content=content))
    _add_linked(files, config)
    config.nav = complete_navigation(config.nav or [], _page_paths(files))
    return files


def _with_contents(text: str, made: dict[str, str]) -> str:
    """The first page of the reference, with links to the pages that were made."""
    rows = [
        f"- [{re.sub('^# ', '', content.partition(chr(10))[0])}]({path.removeprefix('reference/')})"
        for path, content in made.items()
    ]
    return f"{text.rstrip()}\n\n" + "\n".join(rows) + "\n"


def _page_paths(files: Files) -> list[str]:
    return [file.src_uri for file in files.documentation_pages()]


def _add_linked(files: Files, config: MkDocsConfig) -> None:
    """Add files of the repository outside of ``docs/`` to which pages link, and so on."""
    todo = ["CONTRIBUTING.md", "CHANGELOG.md", "config/README.md"]
    for file in files.documentation_pages():
        todo += links.relative_targets(file.content_string, repository_path(file.src_uri))
    done: set[str] = set()
    while todo:
        target = todo.pop()
        path, inside = ROOT / target, target.startswith("docs/") or target in links.HOME
        if target in done or inside or not path.is_file() or ROOT not in path.resolve().parents:
            continue
        done.add(target)
        uri = links.site_path(target)
        if path.suffix.lower() in links.PICTURES:
            files.append(File.generated(config, uri, content=path.read_bytes()))
            continue
        text = path.read_text(encoding="utf-8")[:LARGEST]
        if path.suffix.lower() == ".md":
            todo += links.relative_targets(text, target)
        else:
            text = f"# {target}\n\n````{LISTINGS.get(path.suffix, 'text')}\n{text}\n````\n"
        files.append(File.generated(config, uri, content=text))


def repository_path(uri: str) -> str:
    """Path in the repository of a page of the site."""
    if uri.startswith("repository/"):
        return uri.removeprefix("repository/")
    return f"docs/{uri}"


def complete_navigation(nav: list[Any], pages: list[str]) -> list[Any]:
    """The navigation with its patterns replaced by the pages that exist.

    Pages that no entry names are added to the section FALLBACK, but for the generated listings of
    files below ``repository/``; an entry whose page does not exist is left out.
    """
    named: set[str] = set()

    def expand(entries: list[Any]) -> list[Any]:
        found: list[Any] = []
        for entry in entries:
            title, value = next(iter(entry.items())) if isinstance(entry, dict) else (None, entry)
            if isinstance(value, list):
                found.append({title: expand(value)})
                continue
            matches = [page for page in sorted(pages) if fnmatch.fnmatchcase(page, value)]
            matches = [page for page in matches if page not in named]
            named.update(matches)
            found += [{title: page} if title else page for page in matches]
        return found

    complete = expand(nav)
    rest = [page for page in sorted(pages) if page not in named and "repository/" not in page]
    for entry in complete:
        if isinstance(entry, dict) and FALLBACK in entry:
            entry[FALLBACK] += rest
    return complete


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Regenerate the claims, and make links valid on the site."""
    if page.file.src_uri == "results.md":
        markdown = results.with_claims(markdown, results.read_claims())
    if page.file.src_uri.startswith("reference/"):
        return markdown  # made here, with the links of the site
    return links.rewrite(markdown, repository_path(page.file.src_uri), ROOT)


ROLE = re.compile(r":(?:attr|class|data|exc|func|meth|mod|obj):<code>[.~]*([^<]*)</code>")

CELL_CODE = re.compile(r"(<td[^>]*><code>)([^<]*)(?=</code>)")


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Roles of reStructuredText, which docstrings contain, as plain names; long names in tables
    may break after a dot or an underscore."""
    content = ROLE.sub(lambda match: f"<code>{html.escape(match[1])}</code>", content)
    return CELL_CODE.sub(lambda match: match[1] + _breakable(match[2]), content)


def _breakable(name: str) -> str:
    """A name that may break after a dot, an underscore or a slash between its parts."""
    return re.sub(r"(?<=[A-Za-z])([._/])(?=\w)", r"\1<wbr>", name)
