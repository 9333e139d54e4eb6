"""Fixtures of the workflow's tests: finished runs, and a Slurm."""

from __future__ import annotations

import fcntl
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from .running import (
    ENVIRONMENT,
    command,
    copy_workflow,
    snakemake,
    snakemake_on,
    start,
    wait_until,
)
from .slurm import Slurm, SlurmError, find_obstacle

RESULTS = Path("results", "test")
TABLES = RESULTS / "tables"
COMPARED = [
    TABLES / "flatland_commutation.parquet",
    RESULTS / "data" / "apartment_experiments" / "fetch.rs-stand-in.anywhere.4.1-of-2.parquet",
    TABLES / "mask_curves.parquet",
    RESULTS / "data" / "navigation_curves" / "full.2000.parquet",
]
"""Files that are also computed without a kill, on Slurm if there is one: one of each kind of work
(simulation in 2-D and 3-D, pictures, training)."""


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory, worker_id: str) -> Path:
    """The whole workflow on the test profile: killed with all its children, and resumed.

    The processes of pytest-xdist share one; the first that needs it makes it.
    """
    base = tmp_path_factory.getbasetemp()
    shared = base if worker_id == "master" else base.parent
    folder, done = shared / "finished", shared / "finished.done"
    with (shared / "finished.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            assert not folder.exists(), "making the finished run failed in another process"
            finish_after_a_kill(copy_workflow(folder))
            done.touch()
    return folder


def finish_after_a_kill(folder: Path) -> None:
    """Run the workflow in `folder`, kill it with all its children, and resume it."""
    data = folder / "results" / "test" / "data"

    def finished_shards() -> dict[Path, int]:
        """Shards and when they were written; hidden folders, which come and go, are not entered."""
        return {path: path.stat().st_mtime_ns for path in data.glob("[!.]*/[!.]*.parquet")}

    process = start(command("--cores", "2"), folder, ENVIRONMENT)
    wait_until(lambda: len(finished_shards()) >= 8, process, "part of the work")
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    kept = finished_shards()
    assert kept and not (folder / TABLES).exists()
    assert snakemake(folder, "--unlock").returncode == 0
    run = snakemake(folder, "--cores", "2", "--rerun-incomplete")
    assert run.returncode == 0, run.stderr
    again = [path for path, when in kept.items() if path.stat().st_mtime_ns != when]
    assert len(again) <= 2, f"finished work was done again: {again}"


@pytest.fixture(scope="session")
def slurm_or_obstacle(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Slurm | str]:
    """A running Slurm, or the reason why there is none."""
    obstacle = find_obstacle()
    if obstacle:
        yield obstacle
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
def slurm(slurm_or_obstacle: Slurm | str) -> Slurm:
    """A running Slurm; tests that need it are skipped without one."""
    if isinstance(slurm_or_obstacle, str):
        pytest.skip(f"no Slurm on this machine: {slurm_or_obstacle}")
    return slurm_or_obstacle


class Undisturbed(NamedTuple):
    """A run of COMPARED without a kill: its folder, and the nodes that ran its jobs, if any."""

    folder: Path
    nodes: set[str]


@pytest.fixture(scope="session")
def undisturbed(
    slurm_or_obstacle: Slurm | str, tmp_path_factory: pytest.TempPathFactory
) -> Undisturbed:
    """COMPARED, computed from beginning to end, on Slurm if there is one."""
    folder = copy_workflow(tmp_path_factory.mktemp("undisturbed"))
    if isinstance(slurm_or_obstacle, str):
        run = snakemake(folder, "--cores", "2", *COMPARED)
        assert run.returncode == 0, run.stderr
        return Undisturbed(folder, set())
    before = {job for job, *_ in slurm_or_obstacle.jobs("COMPLETED")}
    run = snakemake_on(slurm_or_obstacle, folder, targets=COMPARED)
    assert run.returncode == 0, run.stderr
    completed = slurm_or_obstacle.jobs("COMPLETED")
    return Undisturbed(folder, {node for job, node, _ in completed if job not in before})
