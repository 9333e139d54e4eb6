"""The workflow on a real Slurm of two nodes, and the faults that only a cluster has: the tables are those of the local run, byte by byte."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from ..workflow.running import copy_workflow, digests, hashes, in_its_place
from .slurm import Slurm, SlurmError, why_not

RESULTS = Path("results", "test")
TABLE = RESULTS / "tables" / "flatland_commutation.parquet"
"""Made from four parts, each a job of its own."""
PARTS = [RESULTS / "data" / "flatland_commutation" / f"{world}.{i}-of-2.parquet" for world in ("furnished", "settled") for i in (1, 2)]
ONCE = 'if mkdir struck 2> /dev/null; then {fault}; fi; exec "$@"'
"""A script that does something bad the first time that it is called, whoever calls it."""
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


def command(*arguments: str) -> list[str]:
    """Snakemake with the profile for Slurm, told what is special here: two small nodes, no accounting, and impatience."""
    return [
        "snakemake", "--profile", "workflow/profiles/slurm", "--configfile", "config/test.yaml", "--local-cores", "2", "--latency-wait", "15",
        "--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "2", "--seconds-between-status-checks", "2",
        "--default-resources", "slurm_partition=short", "mem_mb=1500*attempt", "runtime=5*attempt", *arguments,
    ]  # fmt: skip


def run_on(slurm: Slurm, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command(*arguments), cwd=folder, env=slurm.environment, capture_output=True, text=True, timeout=1800)


def begin_on(slurm: Slurm, folder: Path, *arguments: str) -> subprocess.Popen:
    with (folder / "said.log").open("wb") as said:
        return subprocess.Popen(command(*arguments), cwd=folder, env=slurm.environment, stdout=said, stderr=said, start_new_session=True)


def wait_for(path: Path, process: subprocess.Popen) -> None:
    end = time.monotonic() + 180
    while not path.exists():
        assert process.poll() is None and time.monotonic() < end, f"{path} did not come about"
        time.sleep(0.1)


def expect_equal(finished: Path, folder: Path) -> None:
    files = [TABLE, *PARTS]
    assert digests(folder, files) == digests(finished, files)
    assert not list((folder / RESULTS).rglob(".*.part*"))


def test_the_whole_workflow_gives_the_tables_of_the_local_run(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "whole")
    run = run_on(slurm, folder)
    assert run.returncode == 0, run.stderr
    expected = hashes(finished / RESULTS / "tables")
    assert expected and hashes(folder / RESULTS / "tables") == expected
    nodes = {node for _, node, _ in slurm.jobs("COMPLETED")}
    assert nodes == {"n1", "n2"}


def test_a_job_over_its_memory_is_given_more(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "memory")
    in_its_place(
        folder, "flatland.smk", "flatland-commutation-part", ONCE.format(fault="python3 -c 'import time; x = b\"x\" * (2 << 30); time.sleep(60)'")
    )
    run = run_on(slurm, folder, str(TABLE))
    assert run.returncode == 0, run.stderr
    assert "Trying to restart job" in run.stderr
    expect_equal(finished, folder)


def test_a_job_over_its_time_is_given_more(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "time")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", ONCE.format(fault="sleep 300"))
    run = run_on(slurm, folder, "--set-resources", "flatland_commutation_part:runtime=1*attempt", "--", str(TABLE))
    assert run.returncode == 0, run.stderr
    assert "Trying to restart job" in run.stderr and slurm.jobs("TIMEOUT")
    expect_equal(finished, folder)


def test_a_lost_node(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "node")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", SLOWLY)
    process = begin_on(slurm, folder, str(TABLE))
    wait_for(folder / "begun.n1", process)
    slurm.lose("n1")
    assert process.wait(timeout=600) == 0, (folder / "said.log").read_text()
    slurm.start_node("n1")
    slurm.wait_for_nodes()
    expect_equal(finished, folder)


def test_a_killed_controller_whose_jobs_go_on(slurm: Slurm, finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "controller")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", SLOWLY)
    process = begin_on(slurm, folder, str(TABLE))
    wait_for(folder / "begun.n1", process)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert slurm.jobs("RUNNING,PENDING"), "nothing went on"
    run = run_on(slurm, folder, str(TABLE))
    assert run.returncode != 0 and "unlock" in run.stderr
    assert run_on(slurm, folder, "--unlock").returncode == 0
    run = run_on(slurm, folder, str(TABLE))
    assert run.returncode == 0, run.stderr
    expect_equal(finished, folder)
