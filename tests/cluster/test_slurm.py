"""The workflow on a real Slurm of two nodes, and the faults that only a cluster has: the tables are those of the local run, byte by byte."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from ..workflow.running import copy_workflow, digests, hashes, in_its_place
from .slurm import Slurm, SlurmError, why_not

SNAKEMAKE = str(Path(sys.executable).parent / "snakemake")
RESULTS = Path("results", "test")
TABLE = RESULTS / "tables" / "flatland_commutation.parquet"
"""Made from four parts, each a job of its own."""
PARTS = [RESULTS / "data" / "flatland_commutation" / f"{world}.{i}-of-2.parquet" for world in ("furnished", "settled") for i in (1, 2)]
OVER_LIMITS = """
if mkdir over-memory 2> /dev/null; then python3 -c 'import time; x = b"x" * (2 << 30); time.sleep(60)'
elif mkdir over-time 2> /dev/null; then sleep 300
fi
exec "$@"
"""
"""What one job, and another, does the first time that it is tried."""
SLOWLY = 'touch begun.$SLURMD_NODENAME; sleep 8; exec "$@"'


@pytest.fixture(scope="module")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Slurm]:
    """A Slurm that runs."""
    lacking = why_not()
    if lacking:
        pytest.skip(f"no Slurm on this machine: {lacking}")
    slurm = Slurm(tmp_path_factory.mktemp("slurm"))
    try:
        slurm.start()
    except SlurmError as error:
        slurm.stop()
        pytest.skip(f"no Slurm on this machine: {error}")
    yield slurm
    slurm.stop()


def command(*arguments: str, targets: Sequence[Path] = ()) -> list[str]:
    """Snakemake with the profile for Slurm, told what is special here: two small nodes, no accounting, and impatience."""
    return [
        SNAKEMAKE, "--profile", "workflow/profiles/slurm", "--configfile", "config/test.yaml", "--local-cores", "2", "--latency-wait", "15",
        "--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "2", "--seconds-between-status-checks", "2",
        "--default-resources", "slurm_partition=short", "mem_mb=1500*attempt", "runtime=5*attempt", *arguments, "--", *targets,
    ]  # fmt: skip


def run_on(slurm: Slurm, folder: Path, *arguments: str, targets: Sequence[Path] = ()) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command(*arguments, targets=targets), cwd=folder, env=slurm.environment, capture_output=True, text=True, timeout=1800)


def begin_on(slurm: Slurm, folder: Path, *arguments: str, targets: Sequence[Path] = ()) -> subprocess.Popen:
    with (folder / "said.log").open("wb") as said:
        return subprocess.Popen(
            command(*arguments, targets=targets), cwd=folder, env=slurm.environment, stdout=said, stderr=said, start_new_session=True
        )


def wait_for(path: Path, process: subprocess.Popen) -> None:
    end = time.monotonic() + 180
    while not path.exists():
        assert process.poll() is None and time.monotonic() < end, f"{path} did not come about"
        time.sleep(0.1)


def expect_equal(finished: Path, folder: Path) -> None:
    files = [TABLE, *PARTS]
    assert digests(folder, files) == digests(finished, files)
    assert not list((folder / RESULTS).rglob(".*.part*"))


@pytest.fixture(scope="module")
def over_limits(slurm: Slurm, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, subprocess.Popen]]:
    """A run whose jobs take too much at first, and its folder."""
    folder = copy_workflow(tmp_path_factory.mktemp("limits") / "limits")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", OVER_LIMITS)
    process = begin_on(slurm, folder, "--set-resources", "flatland_commutation_part:runtime=1*attempt", targets=[TABLE])
    yield folder, process
    process.kill()


@pytest.mark.usefixtures("over_limits")  # which mostly waits, meanwhile
def test_the_whole_workflow_gives_the_tables_of_the_local_run(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "whole")
    run = run_on(slurm, folder)
    assert run.returncode == 0, run.stderr
    expected = hashes(finished / RESULTS / "tables")
    assert expected and hashes(folder / RESULTS / "tables") == expected
    nodes = {node for _, node, _ in slurm.jobs("COMPLETED")}
    assert nodes == {"n1", "n2"}


def test_jobs_over_their_memory_and_their_time_are_given_more(slurm: Slurm, finished: Path, over_limits: tuple[Path, subprocess.Popen]) -> None:
    folder, process = over_limits
    code, said = process.wait(timeout=900), (folder / "said.log").read_text()
    assert code == 0, said
    assert (folder / "over-memory").exists() and (folder / "over-time").exists()
    assert said.count("Trying to restart job") >= 2 and slurm.jobs("TIMEOUT")
    expect_equal(finished, folder)


def test_a_lost_node(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "node")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", SLOWLY)
    process = begin_on(slurm, folder, targets=[TABLE])
    wait_for(folder / "begun.n1", process)
    slurm.lose("n1")
    assert process.wait(timeout=600) == 0, (folder / "said.log").read_text()
    slurm.start_node("n1")
    slurm.wait_for_nodes()
    expect_equal(finished, folder)


def test_a_killed_controller_whose_jobs_go_on(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "controller")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", SLOWLY)
    process = begin_on(slurm, folder, targets=[TABLE])
    wait_for(folder / "begun.n1", process)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert slurm.jobs("RUNNING,PENDING"), "nothing went on"
    run = run_on(slurm, folder, targets=[TABLE])
    assert run.returncode != 0 and "unlock" in run.stderr
    assert run_on(slurm, folder, "--unlock").returncode == 0
    run = run_on(slurm, folder, targets=[TABLE])
    assert run.returncode == 0, run.stderr
    expect_equal(finished, folder)
