"""Running the workflow in a folder of its own, as a user would."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path

from .slurm import Slurm

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(sys.executable).parent
ENVIRONMENT = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
TIMEOUT_S = 3600
"""Seconds after which a program is taken to hang: many times what any takes on a slow machine that
other work shares."""


def copy_workflow(folder: Path) -> Path:
    """Copy what the workflow needs, without results."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("workflow", "config", "profiles"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


def run(
    arguments: Iterable[str | Path], folder: Path, environment: dict[str, str] = ENVIRONMENT
) -> subprocess.CompletedProcess[str]:
    """Run a program to its end and capture its output."""
    return subprocess.run(
        [str(argument) for argument in arguments], cwd=folder, env=environment,
        capture_output=True, text=True, timeout=TIMEOUT_S,
    )  # fmt: skip


def command(*arguments: str | Path, layers: Iterable[str] = ()) -> list[str]:
    """Snakemake on the test profile, with further configuration files merged over it."""
    config = ["--configfile", "config/test.yaml", *layers]
    return [str(BIN / "snakemake"), *config, "--quiet", "all", *map(str, arguments)]


def snakemake(folder: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run the workflow on the test profile."""
    return run(command(*arguments), folder)


def dry_run(folder: Path, layer: str | Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Plan the workflow with a further configuration file, and print the plan."""
    loud = ["--workflow-profile", "none"]  # with the reason of every job
    line = [BIN / "snakemake", "--configfile", "config/test.yaml", layer, "--dry-run", *loud,
            *arguments]  # fmt: skip
    return run(line, folder)


def slurm_command(*arguments: str, targets: Iterable[Path] = ()) -> list[str]:
    """Snakemake with the profile for Slurm, adapted to two small nodes without accounting."""
    return [
        str(BIN / "snakemake"), "--profile", "profiles/slurm",
        "--configfile", "config/test.yaml", "--local-cores", "2", "--latency-wait", "15",
        "--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "2",
        "--seconds-between-status-checks", "2", "--default-resources", "slurm_partition=short",
        "mem_mb=1500*attempt", "runtime=30*attempt", *arguments, "--", *map(str, targets),
    ]  # fmt: skip


def snakemake_on(
    slurm: Slurm, folder: Path, *arguments: str, targets: Iterable[Path] = ()
) -> subprocess.CompletedProcess[str]:
    """Run the workflow on a Slurm."""
    return run(slurm_command(*arguments, targets=targets), folder, slurm.environment)


def start(arguments: list[str], folder: Path, environment: dict[str, str]) -> subprocess.Popen:
    """Start a program in a session of its own; its output goes to ``output.log``."""
    with (folder / "output.log").open("wb") as log:
        return subprocess.Popen(
            arguments, cwd=folder, env=environment, stdout=log, stderr=log, start_new_session=True
        )


def wait_until(condition: Callable[[], bool], process: subprocess.Popen, what: str) -> None:
    """Return once `condition` holds; fail if the program ends before that, or hangs."""
    end = time.monotonic() + TIMEOUT_S
    while not condition():
        assert process.poll() is None and time.monotonic() < end, f"{what} did not happen"
        time.sleep(0.1)


def hash_files(folder: Path, files: Iterable[Path]) -> dict[Path, str | None]:
    """SHA-256 of each of `files`, relative to `folder`; None for a missing one."""
    return {
        file: hashlib.sha256((folder / file).read_bytes()).hexdigest()
        if (folder / file).exists()
        else None
        for file in files
    }


def hash_tables(tables: Path) -> dict[str, str]:
    """SHA-256 of every table in a folder."""
    return {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(tables.glob("*.parquet"))
    }


def wrap_command(folder: Path, rule_file: str, command: str, script: str) -> None:
    """Let a rule of a copy of the workflow run a script, with its command as the arguments."""
    rules = folder / "workflow" / "rules" / rule_file
    text, original = rules.read_text(), f'"sensory-commutativity {command} '
    assert original in text
    rules.write_text(text.replace(original, f'"sh script.sh sensory-commutativity {command} '))
    (folder / "script.sh").write_text(script)
