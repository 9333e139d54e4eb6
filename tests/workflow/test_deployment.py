"""The workflow as others deploy it: as a module, from another folder, with a configuration there.

The Snakefile below is what ``snakedeploy deploy-workflow`` writes, which copies ``config`` and
``profiles`` beside it.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from .running import BIN, ROOT, run

SNAKEFILE = """
from snakemake.utils import min_version

min_version("6.10.0")

configfile: "config/config.yaml"

module sensory_commutativity:
    snakefile: "{snakefile}"
    config: config

use rule * from sensory_commutativity
"""
TARGET = Path("results", "test", "tables", "flatland_commutation.parquet")


@pytest.fixture(scope="module")
def deployed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("deployed")
    for name in ("config", "profiles"):
        shutil.copytree(ROOT / name, folder / name)
    (folder / "workflow").mkdir()
    snakefile = SNAKEFILE.format(snakefile=ROOT / "workflow" / "Snakefile")
    (folder / "workflow" / "Snakefile").write_text(snakefile)
    return folder


def snakemake(folder: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return run([BIN / "snakemake", "--configfile", "config/test.yaml", *arguments], folder)


def test_everything_can_be_planned(deployed: Path) -> None:
    plan = snakemake(deployed, "--dry-run", "--cores", "2")
    assert plan.returncode == 0, plan.stderr
    assert "paper_comparison" in plan.stdout and "checksums" in plan.stdout
    assert not (deployed / "results").exists()


def test_a_target_is_made_with_a_robot_beside_the_configuration(deployed: Path) -> None:
    shutil.copy(deployed / "config" / "robots" / "fetch.yaml",
                deployed / "config" / "robots" / "mine.yaml")  # fmt: skip
    layer = deployed / "config" / "test.yaml"
    text = layer.read_text()
    robots = "apartment:\n  robots: {mine: {description: robots/mine.yaml}}\n"
    layer.write_text(text.replace("apartment:\n", robots, 1))
    made = snakemake(deployed, "--cores", "2", TARGET)
    assert made.returncode == 0, made.stderr
    assert (deployed / TARGET).is_file()
    resolved = (deployed / "results" / "test" / "config.yaml").read_text()
    assert "../../config/robots/mine.yaml" in resolved
    assert not (deployed / "results" / "test" / ".lock").exists()


def test_the_workflow_has_no_lints_but_for_its_environment() -> None:
    result = run([BIN / "snakemake", "--lint", "text"], ROOT)
    lints = {line.strip() for line in result.stderr.splitlines() if line.startswith("    * ")}
    assert lints <= {"* Specify a conda environment or container for each rule.:"}, lints
