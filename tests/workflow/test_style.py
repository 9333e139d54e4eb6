"""The workflow's files keep Snakemake's own style."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_snakefmt_has_nothing_to_change() -> None:
    tool = Path(sys.executable).parent / "snakefmt"
    run = subprocess.run(
        [tool, "--check", "Snakefile", "workflow"], cwd=ROOT, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr


def test_every_figure_has_a_caption() -> None:
    from sensory_commutativity.studies.catalogue import FIGURES

    for name in (*FIGURES, "flatland_experiment", "navigation_episode"):
        caption = ROOT / "workflow" / "report" / f"{name}.rst"
        assert len(caption.read_text()) > 100, f"{caption} says too little"
