"""What the tests of the workflow share: two whole runs of it, and a Slurm."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from sensory_commutativity.running import (
    ENVIRONMENT,
    begin,
    command,
    copy_workflow,
    snakemake,
    snakemake_on,
    wait_until,
)
from sensory_commutativity.slurm import Slurm, SlurmError, why_not


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole workflow on the test profile: begun on one core, killed with all that it had started, and resumed on two."""
    folder = copy_workflow(tmp_path_factory.mktemp("finished"))
    data = folder / "results" / "test" / "data"

    def done() -> dict[Path, int]:
        """Tables below ``data``, and when they were written; not the hidden ones, batches of a job under way."""
        found = (
            p
            for p in data.rglob("*.parquet")
            if not any(part.startswith(".") for part in p.relative_to(data).parts)
        )
        return {p: p.stat().st_mtime_ns for p in found}

    process = begin(command("--cores", "1"), folder, ENVIRONMENT)
    wait_until(lambda: len(done()) >= 8, process, "half of the work")
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = done()
    assert kept and not (folder / "results" / "test" / "tables").exists()
    assert snakemake(folder, "--unlock").returncode == 0
    run = snakemake(folder, "--cores", "2", "--rerun-incomplete")
    assert run.returncode == 0, run.stderr
    again = [p for p, when in kept.items() if p.stat().st_mtime_ns != when]
    assert len(again) <= 1, f"finished work was done again: {again}"
    return folder


@pytest.fixture(scope="session")
def slurm_or_why_not(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Slurm | str]:
    """A Slurm that runs, or why there is none."""
    lacking = why_not()
    if lacking:
        yield lacking
        return
    slurm = Slurm(tmp_path_factory.mktemp("slurm"))
    try:
        slurm.start()
        yield slurm
    except SlurmError as error:
        yield str(error)
    finally:
        slurm.stop()


@pytest.fixture(scope="session")
def slurm(slurm_or_why_not: Slurm | str) -> Slurm:
    """A Slurm that runs; whoever asks for it is skipped where there is none."""
    if isinstance(slurm_or_why_not, str):
        pytest.skip(f"no Slurm on this machine: {slurm_or_why_not}")
    return slurm_or_why_not


class Undisturbed(NamedTuple):
    """A whole run from beginning to end: its folder, and the nodes on which its jobs ran, none where it was a local run."""

    folder: Path
    nodes: set[str]


@pytest.fixture(scope="session")
def undisturbed(
    slurm_or_why_not: Slurm | str, tmp_path_factory: pytest.TempPathFactory
) -> Undisturbed:
    """The whole workflow on the test profile, on Slurm where there is one."""
    folder = copy_workflow(tmp_path_factory.mktemp("undisturbed"))
    if isinstance(slurm_or_why_not, str):
        run = snakemake(folder, "--cores", "2")
        assert run.returncode == 0, run.stderr
        return Undisturbed(folder, set())
    before = {job for job, *_ in slurm_or_why_not.jobs("COMPLETED")}
    run = snakemake_on(slurm_or_why_not, folder)
    assert run.returncode == 0, run.stderr
    return Undisturbed(
        folder, {node for job, node, _ in slurm_or_why_not.jobs("COMPLETED") if job not in before}
    )
