"""The examples of the README run as they stand, from another folder, and the first is short."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from tests.helpers import ROOT

TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS, ids=[f"example-{i + 1}" for i in range(len(BLOCKS))])
def test_the_examples_run(block: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "README.md", "exec"), {})
    plt.close("all")


def test_the_first_example_has_at_most_six_lines() -> None:
    lines = [line for line in BLOCKS[0].splitlines() if line.strip()]
    assert len(lines) <= 6 and "measure(" in BLOCKS[0]


def test_links_lead_to_files() -> None:
    for name in ("README.md", *(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))):
        text, folder = (ROOT / name).read_text(encoding="utf-8"), (ROOT / name).parent
        for target in re.findall(r"\]\(([^)#]+)", text):
            if "://" not in target:
                assert (folder / target).exists(), f"{name}: {target}"
