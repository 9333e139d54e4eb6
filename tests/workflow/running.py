"""Running the workflow in a folder of its own, as a user would."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}


def copy_workflow(folder: Path) -> Path:
    """A copy of what the workflow needs, without results."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / "Snakefile", folder)
    for name in ("workflow", "config"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


def command(*arguments: str, profile: str = "config/test.yaml") -> list[str]:
    """Snakemake on a profile."""
    return [str(Path(sys.executable).parent / "snakemake"), "--configfile", profile, "--quiet", "all", *arguments]


def snakemake(folder: Path, *arguments: str, profile: str = "config/test.yaml") -> subprocess.CompletedProcess[str]:
    return subprocess.run(command(*arguments, profile=profile), cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=1800)


def digests(folder: Path, files: Iterable[Path]) -> dict[Path, str | None]:
    """SHA-256 of each of `files`, relative to `folder`; None for one that is not there."""
    return {file: hashlib.sha256((folder / file).read_bytes()).hexdigest() if (folder / file).exists() else None for file in files}


def in_its_place(folder: Path, rule_file: str, command: str, script: str) -> None:
    """Let a rule of a copy of the workflow run a script, with the command and its arguments as the script's own, in place of the command."""
    rules = folder / "workflow" / "rules" / rule_file
    text = rules.read_text()
    assert f'"sensory-commutativity {command} ' in text
    rules.write_text(text.replace(f'"sensory-commutativity {command} ', f'"sh faulty.sh sensory-commutativity {command} '))
    (folder / "faulty.sh").write_text(script)


def hashes(tables: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(tables.glob("*.parquet"))}
