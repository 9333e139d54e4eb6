"""The workflow on a real Slurm of two nodes, and the faults that only a cluster has: the tables
equal those of the local run, byte by byte."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from .conftest import COMPARED, Undisturbed
from .running import (
    TIMEOUT_S,
    copy_workflow,
    hash_files,
    slurm_command,
    snakemake_on,
    start,
    wait_until,
    wrap_command,
)
from .slurm import Slurm

RESULTS = Path("results", "test")
TABLE = RESULTS / "tables" / "flatland_commutation.parquet"
SHARD_COMMAND = "table flatland_commutation_experiments"
SHARDS = [
    RESULTS / "data" / "flatland_commutation_experiments" / f"{world}.{i}-of-2.parquet"
    for world in ("furnished", "settled")
    for i in (1, 2)
]
"""The inputs of TABLE, each a job of its own."""
OVER_LIMITS = """
if mkdir over-memory 2> /dev/null; then
    python3 -c 'import time; x = b"x" * (2 << 30); time.sleep(60)'
elif mkdir over-time 2> /dev/null; then sleep 300
fi
exec "$@"
"""
"""What one job, and then another, does at its first try."""
DELAYED_COMMAND = 'touch started.$SLURMD_NODENAME; sleep 8; exec "$@"'


def assert_equal(finished: Path, folder: Path) -> None:
    files = [TABLE, *SHARDS]
    assert hash_files(folder, files) == hash_files(finished, files)
    assert not list((folder / RESULTS).rglob(".*.part*"))


def start_slowly(slurm: Slurm, folder: Path) -> subprocess.Popen:
    """Start a run whose jobs take their time; returns when one runs on n1."""
    wrap_command(folder, "flatland.smk", SHARD_COMMAND, DELAYED_COMMAND)
    process = start(slurm_command(targets=[TABLE]), folder, slurm.environment)
    wait_until((folder / "started.n1").exists, process, "a job on n1")
    return process


@pytest.fixture(scope="module")
def over_limits(
    slurm: Slurm, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Path, subprocess.Popen]]:
    """A run whose jobs first take too much memory and time, and its folder."""
    folder = copy_workflow(tmp_path_factory.mktemp("limits") / "limits")
    wrap_command(folder, "flatland.smk", SHARD_COMMAND, OVER_LIMITS)
    limits = "flatland_commutation_experiments_shard:runtime=1*attempt"
    arguments = slurm_command("--set-resources", limits, targets=[TABLE])
    process = start(arguments, folder, slurm.environment)
    yield folder, process
    process.kill()


@pytest.mark.usefixtures("over_limits")  # most of its time is waiting, so it goes on meanwhile
def test_a_run_uses_both_nodes(slurm: Slurm, undisturbed: Undisturbed) -> None:
    assert undisturbed.nodes == {"n1", "n2"}


def test_tables_equal_those_of_the_run_that_was_killed_here_and_resumed(
    finished: Path, undisturbed: Undisturbed
) -> None:
    expected = hash_files(undisturbed.folder, COMPARED)
    assert all(expected.values()) and hash_files(finished, COMPARED) == expected


def test_jobs_over_their_memory_and_time_get_more(
    slurm: Slurm, finished: Path, over_limits: tuple[Path, subprocess.Popen]
) -> None:
    folder, process = over_limits
    code, output = process.wait(timeout=TIMEOUT_S), (folder / "output.log").read_text()
    assert code == 0, output
    assert (folder / "over-memory").exists() and (folder / "over-time").exists()
    assert output.count("Trying to restart job") >= 2 and slurm.jobs("TIMEOUT")
    assert_equal(finished, folder)


def test_a_lost_node(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "node")
    process = start_slowly(slurm, folder)
    slurm.lose("n1")
    assert process.wait(timeout=TIMEOUT_S) == 0, (folder / "output.log").read_text()
    slurm.start_node("n1")
    slurm.wait_for_nodes()
    assert_equal(finished, folder)


def test_a_killed_controller_whose_jobs_continue(
    slurm: Slurm, finished: Path, tmp_path: Path
) -> None:
    folder = copy_workflow(tmp_path / "controller")
    process = start_slowly(slurm, folder)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert slurm.jobs("RUNNING,PENDING"), "no job continued"
    run = snakemake_on(slurm, folder, targets=[TABLE])
    assert run.returncode != 0 and "unlock" in run.stderr
    assert snakemake_on(slurm, folder, "--unlock").returncode == 0
    run = snakemake_on(slurm, folder, targets=[TABLE])
    assert run.returncode == 0, run.stderr
    assert_equal(finished, folder)
