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

from sensory_commutativity.slurm import Slurm

ROOT = Path(__file__).resolve().parents[2]
ENVIRONMENT = {
    **os.environ,
    "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
}


def copy_workflow(folder: Path) -> Path:
    """A copy of what the workflow needs, without results."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(ROOT / "Snakefile", folder)
    for name in ("workflow", "config"):
        shutil.copytree(ROOT / name, folder / name)
    return folder


def command(*arguments: str, profile: str = "config/test.yaml") -> list[str]:
    """Snakemake on a profile."""
    return [
        str(Path(sys.executable).parent / "snakemake"),
        "--configfile",
        profile,
        "--quiet",
        "all",
        *arguments,
    ]


def slurm_command(*arguments: str, targets: Iterable[Path] = ()) -> list[str]:
    """Snakemake with the profile for Slurm, told what is special here: two small nodes, no accounting, and impatience."""
    return [
        command()[0], "--profile", "workflow/profiles/slurm", "--configfile", "config/test.yaml", "--local-cores", "2", "--latency-wait", "15",
        "--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "2", "--seconds-between-status-checks", "2",
        "--default-resources", "slurm_partition=short", "mem_mb=1500*attempt", "runtime=5*attempt", *arguments, "--", *map(str, targets),
    ]  # fmt: skip


def snakemake_on(
    slurm: Slurm, folder: Path, *arguments: str, targets: Iterable[Path] = ()
) -> subprocess.CompletedProcess[str]:
    arguments = slurm_command(*arguments, targets=targets)
    return subprocess.run(
        arguments, cwd=folder, env=slurm.environment, capture_output=True, text=True, timeout=1800
    )


def begin(arguments: list[str], folder: Path, environment: dict[str, str]) -> subprocess.Popen:
    """Begin a program in a session of its own; what it says goes to ``said.log``."""
    with (folder / "said.log").open("wb") as said:
        return subprocess.Popen(
            arguments, cwd=folder, env=environment, stdout=said, stderr=said, start_new_session=True
        )


def wait_until(happened: Callable[[], bool], process: subprocess.Popen, what: str) -> None:
    """Return when it has happened; fail when the program ends before, or in five minutes."""
    end = time.monotonic() + 300
    while not happened():
        assert process.poll() is None and time.monotonic() < end, f"{what} did not come about"
        time.sleep(0.1)


def snakemake(
    folder: Path, *arguments: str, profile: str = "config/test.yaml"
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command(*arguments, profile=profile),
        cwd=folder,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=1800,
    )


def digests(folder: Path, files: Iterable[Path]) -> dict[Path, str | None]:
    """SHA-256 of each of `files`, relative to `folder`; None for one that is not there."""
    return {
        file: hashlib.sha256((folder / file).read_bytes()).hexdigest()
        if (folder / file).exists()
        else None
        for file in files
    }


def in_its_place(folder: Path, rule_file: str, command: str, script: str) -> None:
    """Let a rule of a copy of the workflow run a script, with the command and its arguments as the script's own, in place of the command."""
    rules = folder / "workflow" / "rules" / rule_file
    text = rules.read_text()
    assert f'"sensory-commutativity {command} ' in text
    rules.write_text(
        text.replace(
            f'"sensory-commutativity {command} ', f'"sh faulty.sh sensory-commutativity {command} '
        )
    )
    (folder / "faulty.sh").write_text(script)


def hashes(tables: Path) -> dict[str, str]:
    return {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(tables.glob("*.parquet"))
    }
