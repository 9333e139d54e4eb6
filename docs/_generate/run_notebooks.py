"""Run the notebooks of the tutorials.

    python docs/_generate/run_notebooks.py         runs them and stores their outputs

``make pages`` runs it. What is written to the standard error, such as a progress bar, is left out.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import nbformat
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbformat import NotebookNode

TUTORIALS = Path(__file__).resolve().parents[1] / "tutorials"
NOTEBOOKS = sorted(TUTORIALS.glob("*.ipynb"))
TIMEOUT = 300
"""Seconds for a cell; chosen: a hundred times the slowest."""


def run(notebook: Path) -> NotebookNode:
    """The notebook with the outputs of a fresh kernel that starts in its folder.

    Raises nbclient's CellExecutionError if a cell fails.
    """
    content = nbformat.read(notebook, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        client = NotebookClient(
            content,
            timeout=TIMEOUT,
            coalesce_streams=True,
            record_timing=False,
            resources={"metadata": {"path": str(notebook.parent)}},
        )
        client.km = AsyncKernelManager(
            kernel_name="python3", transport="ipc", ip=f"{folder}/kernel"
        )  # sockets in a folder of its own instead of open ports
        client.execute()
    for number, cell in enumerate(content.cells):
        cell.id = f"cell-{number}"
        cell.metadata = NotebookNode()
        if cell.cell_type == "code":
            cell.outputs = [
                one
                for one in cell.outputs
                if not (one.output_type == "stream" and one.name == "stderr")
            ]
    content.metadata = NotebookNode(
        kernelspec={"display_name": "Python 3", "language": "python", "name": "python3"},
        language_info={"name": "python"},
    )
    return content


def main() -> None:
    for notebook in NOTEBOOKS:
        nbformat.write(run(notebook), notebook)
        print(notebook.name, file=sys.stderr)


if __name__ == "__main__":
    main()
