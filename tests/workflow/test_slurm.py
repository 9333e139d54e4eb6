"""The workflow on a real Slurm of two nodes, and the faults that only a cluster has: the tables are those of the local run, byte by byte."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from sensory_commutativity.conftest import Undisturbed
from sensory_commutativity.running import (
    begin,
    copy_workflow,
    digests,
    hashes,
    in_its_place,
    slurm_command,
    snakemake_on,
    wait_until,
)
from sensory_commutativity.slurm import Slurm

RESULTS = Path("results", "test")
TABLE = RESULTS / "tables" / "flatland_commutation.parquet"
"""Made from four parts, each a job of its own."""
PARTS = [
    RESULTS / "data" / "flatland_commutation" / f"{world}.{i}-of-2.parquet"
    for world in ("furnished", "settled")
    for i in (1, 2)
]
OVER_LIMITS = """
if mkdir over-memory 2> /dev/null; then python3 -c 'import time; x = b"x" * (2 << 30); time.sleep(60)'
elif mkdir over-time 2> /dev/null; then sleep 300
fi
exec "$@"
"""
"""What one job, and another, does the first time that it is tried."""
SLOWLY = 'touch begun.$SLURMD_NODENAME; sleep 8; exec "$@"'


def expect_equal(finished: Path, folder: Path) -> None:
    files = [TABLE, *PARTS]
    assert digests(folder, files) == digests(finished, files)
    assert not list((folder / RESULTS).rglob(".*.part*"))


def begin_slowly(slurm: Slurm, folder: Path) -> subprocess.Popen:
    """Begin a run whose jobs take their time; returns when one is on n1."""
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", SLOWLY)
    process = begin(slurm_command(targets=[TABLE]), folder, slurm.environment)
    wait_until((folder / "begun.n1").exists, process, "a job on n1")
    return process


@pytest.fixture(scope="module")
def over_limits(
    slurm: Slurm, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Path, subprocess.Popen]]:
    """A run whose jobs take too much at first, and its folder."""
    folder = copy_workflow(tmp_path_factory.mktemp("limits") / "limits")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", OVER_LIMITS)
    arguments = slurm_command(
        "--set-resources", "flatland_commutation_part:runtime=1*attempt", targets=[TABLE]
    )
    process = begin(arguments, folder, slurm.environment)
    yield folder, process
    process.kill()


@pytest.mark.usefixtures("over_limits")  # which mostly waits, meanwhile
def test_the_whole_workflow_runs_on_both_nodes(slurm: Slurm, undisturbed: Undisturbed) -> None:
    assert undisturbed.nodes == {"n1", "n2"}


def test_every_table_is_that_of_the_run_that_was_killed_here_and_resumed(
    finished: Path, undisturbed: Undisturbed
) -> None:
    expected = hashes(undisturbed.folder / RESULTS / "tables")
    assert expected and hashes(finished / RESULTS / "tables") == expected


def test_jobs_over_their_memory_and_their_time_are_given_more(
    slurm: Slurm, finished: Path, over_limits: tuple[Path, subprocess.Popen]
) -> None:
    folder, process = over_limits
    code, said = process.wait(timeout=900), (folder / "said.log").read_text()
    assert code == 0, said
    assert (folder / "over-memory").exists() and (folder / "over-time").exists()
    assert said.count("Trying to restart job") >= 2 and slurm.jobs("TIMEOUT")
    expect_equal(finished, folder)


def test_a_lost_node(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "node")
    process = begin_slowly(slurm, folder)
    slurm.lose("n1")
    assert process.wait(timeout=600) == 0, (folder / "said.log").read_text()
    slurm.start_node("n1")
    slurm.wait_for_nodes()
    expect_equal(finished, folder)


def test_a_killed_controller_whose_jobs_go_on(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "controller")
    process = begin_slowly(slurm, folder)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert slurm.jobs("RUNNING,PENDING"), "nothing went on"
    run = snakemake_on(slurm, folder, targets=[TABLE])
    assert run.returncode != 0 and "unlock" in run.stderr
    assert snakemake_on(slurm, folder, "--unlock").returncode == 0
    run = snakemake_on(slurm, folder, targets=[TABLE])
    assert run.returncode == 0, run.stderr
    expect_equal(finished, folder)
