"""A notebook as a page: its Markdown, its code, and the outputs that are stored in it."""

from __future__ import annotations

import base64
import re
from pathlib import Path
from typing import Any

import nbformat


def notebook_page(notebook: Path) -> tuple[str, dict[str, bytes]]:
    """Markdown of a notebook, and its pictures by the names that the Markdown uses.

    Pictures are PNG; of other outputs, the plain text is shown, and nothing of what was written to
    the standard error.
    """
    parts: list[str] = []
    pictures: dict[str, bytes] = {}
    for cell in nbformat.read(notebook, as_version=4).cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
        elif cell.cell_type == "code" and cell.source.strip():
            parts.append(_fence("python", cell.source))
            for output in cell.outputs:
                parts += _output(output, notebook.stem, pictures)
    parts.append(
        f"This page is the notebook `{notebook.name}`, which lies beside the pages of the "
        "documentation in the repository."
    )
    return "\n\n".join(parts) + "\n", pictures


def _output(output: Any, stem: str, pictures: dict[str, bytes]) -> list[str]:
    if output.output_type == "stream":
        return [_fence("text", output.text, ".output")] if output.name == "stdout" else []
    data = output.get("data", {})
    if "image/png" in data:
        name = f"{stem}-{len(pictures) + 1}.png"
        pictures[name] = base64.b64decode(data["image/png"])
        return [f"![Output of the code above]({name})"]
    return [_fence("text", data["text/plain"], ".output")] if "text/plain" in data else []


def _fence(language: str, text: str, css: str = "") -> str:
    ticks = "`" * max(3, 1 + max((len(run) for run in re.findall(r"`+", text)), default=0))
    info = f"{{.{language} {css}}}" if css else language
    return f"{ticks}{info}\n{text.rstrip()}\n{ticks}"
