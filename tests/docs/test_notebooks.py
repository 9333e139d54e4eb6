"""The notebooks run, and what they show is what they print."""

from __future__ import annotations

import re
from pathlib import Path

import nbformat
import pytest
from nbformat import NotebookNode

from tests.docs.generate import notebooks, run_notebooks

NUMBERS_VARY = {"gymnasium-environment"}
"""Notebooks with numbers of a physics engine, whose last digits depend on the processor."""


def printed(notebook: NotebookNode, mask_numbers: bool) -> list[str]:
    """What the cells of a notebook print, without its pictures."""
    texts = []
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            text = output.get("text") or output.get("data", {}).get("text/plain", "")
            if not text.startswith("<Figure"):
                texts.append(re.sub(r"[\d.]+|\s+|[-+]", "#", text) if mask_numbers else text)
    return texts


@pytest.mark.parametrize("notebook", run_notebooks.NOTEBOOKS, ids=lambda path: path.stem)
def test_the_notebook_prints_what_it_shows(notebook: Path) -> None:
    fresh, stored = run_notebooks.run(notebook), nbformat.read(notebook, as_version=4)
    mask = notebook.stem in NUMBERS_VARY
    assert printed(fresh, mask) == printed(stored, mask), "make pages stores the outputs anew"


def test_a_notebook_becomes_a_page(tmp_path: Path) -> None:
    code = nbformat.v4.new_code_cell("print('``` in a block')")
    code.outputs = [
        nbformat.v4.new_output("stream", name="stdout", text="``` in a block\n"),
        nbformat.v4.new_output("stream", name="stderr", text="a progress bar"),
        nbformat.v4.new_output("display_data", {"image/png": "aGVsbG8=", "text/plain": "<Figure>"}),
        nbformat.v4.new_output("execute_result", {"text/plain": "3"}, execution_count=1),
    ]
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_markdown_cell("# A title"), code])
    nbformat.write(book, tmp_path / "book.ipynb")
    page, pictures = notebooks.notebook_page(tmp_path / "book.ipynb")
    assert page.startswith("# A title\n") and "a progress bar" not in page
    assert pictures == {"book-1.png": b"hello"} and "(book-1.png)" in page
    assert "````{.text .output}\n``` in a block\n````" in page
    assert "```{.text .output}\n3\n```" in page
