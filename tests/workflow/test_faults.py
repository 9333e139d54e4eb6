"""Injected faults: each ends in complete results that equal those of the finished run. Faults of a
cluster are in test_slurm.py."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
from collections.abc import Iterable
from pathlib import Path

import pytest

from .running import (
    BIN,
    ENVIRONMENT,
    command,
    copy_workflow,
    hash_files,
    hash_tables,
    run,
    snakemake,
    start,
    wait_until,
    wrap_command,
)

RESULTS = Path("results", "test")
SHARD = RESULTS / "data" / "flatland_commutation_experiments" / "furnished.1-of-2.parquet"
SHARD_COMMAND = "table flatland_commutation_experiments"
OF_EACH_KIND = (
    SHARD,
    RESULTS / "data" / "mask_pairs" / "validation.1-of-1.h5",
    RESULTS / "models" / "masks" / "difference.predictor",
    RESULTS / "figures" / "flatland_world.png",
)
"""Files of each kind that take little work."""
DAMAGED = {
    RESULTS / "data" / "flatland_baselines" / "head.parquet": "flipped",
    RESULTS / "data" / "local_scp_experiments" / "poses.1-of-1.h5": "truncated",
    RESULTS / "models" / "masks" / "difference.predictor": "flipped",
    RESULTS / "tables" / "navigation_profiles.parquet": "truncated",
    RESULTS / "figures" / "flatland_world.png": "flipped",
}
"""Finished outputs on which little else depends, and how they are damaged."""
DELAYED_COMMAND = 'touch started; sleep 5; exec "$@"'


def assert_equal(finished: Path, folder: Path, files: Iterable[Path]) -> None:
    """Assert that `files` equal those of the finished run, and that no temporary file is left."""
    expected = hash_files(finished, files)
    assert all(expected.values()) and hash_files(folder, files) == expected
    assert not list((folder / RESULTS).rglob(".*.part*"))


def start_slowly(folder: Path) -> subprocess.Popen:
    """Start a run whose job takes its time; returns when the job has started."""
    wrap_command(folder, "flatland.smk", SHARD_COMMAND, DELAYED_COMMAND)
    process = start(command("--cores", "1", SHARD), folder, ENVIRONMENT)
    wait_until((folder / "started").exists, process, "a job")
    return process


def test_workers_killed_while_they_write_files_of_each_kind(finished: Path, tmp_path: Path) -> None:
    folder, kinds = copy_workflow(tmp_path / "killed"), tmp_path / "kinds"
    kinds.mkdir()
    path = [str(Path(__file__).parent / "killing"), os.environ.get("PYTHONPATH")]
    environment = {**ENVIRONMENT, "PYTHONPATH": os.pathsep.join(filter(None, path))}
    environment["KILLED"] = str(kinds)
    runs = 0
    while any(not (folder / file).exists() for file in OF_EACH_KIND):
        result = run(command("--cores", "2", "--keep-going", *OF_EACH_KIND), folder, environment)
        runs += 1
        assert runs <= 1 + len(OF_EACH_KIND), result.stderr
        complete = [file for file in OF_EACH_KIND if (folder / file).exists()]
        assert hash_files(folder, complete) == hash_files(finished, complete)
    killed = {kind.name for kind in kinds.iterdir()}
    assert runs > 1 and killed >= {".parquet", ".h5", ".predictor", ".png"}
    assert_equal(finished, folder, OF_EACH_KIND)


def damage(path: Path, how: str) -> None:
    """Cut a file in half, or flip a bit in its middle."""
    data = bytearray(path.read_bytes())
    if how == "truncated":
        del data[len(data) // 2 :]
    else:
        data[len(data) // 2] ^= 1
    path.write_bytes(data)


def verify(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    return run([BIN / "sensory-commutativity", "run", "verify", RESULTS, *options], folder)


def test_damaged_files_are_named_and_made_again(finished: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(finished, tmp_path / "damaged")
    assert verify(folder).returncode == 0
    before = hash_tables(folder / RESULTS / "tables")
    for file, how in DAMAGED.items():
        damage(folder / file, how)
    result = verify(folder)
    assert result.returncode == 1
    named = {
        Path(line.split(":")[0])
        for line in result.stdout.splitlines()
        if ": damaged: " in line or ": changed: " in line
    }
    assert named == set(DAMAGED)
    verify(folder, "--remove")
    again = snakemake(folder, "--cores", "2")
    assert again.returncode == 0, again.stderr
    assert_equal(finished, folder, DAMAGED)
    assert hash_tables(folder / RESULTS / "tables") == before
    assert verify(folder).returncode == 0


@pytest.mark.skipif(
    os.name != "posix" or os.geteuid() != 0, reason="mounting a small disk needs root"
)
def test_a_full_disk(finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "full")
    disk = folder / "results"
    disk.mkdir()
    mounted = run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", disk], folder)
    if mounted.returncode:
        pytest.skip(f"no small disk can be mounted here: {mounted.stderr.strip()}")
    try:
        files = [OF_EACH_KIND[1], OF_EACH_KIND[3]]
        result = snakemake(folder, "--cores", "2", "--keep-going", *files)
        assert result.returncode == 1, result.stderr
        logs = "".join(log.read_text() for log in (folder / RESULTS / "logs").rglob("*.log"))
        assert "No space left on device; free some space" in logs + result.stderr
        assert "Traceback" not in logs, logs
        assert not [file for file in files if (folder / file).exists()]
        subprocess.run(["mount", "-o", "remount,size=200m", str(disk)], check=True)
        result = snakemake(folder, "--cores", "2", *files)
        assert result.returncode == 0, result.stderr
        assert_equal(finished, folder, files)
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=False)


def test_a_second_run_in_the_same_checkout_is_refused(finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "twice")
    first = start_slowly(folder)
    loud = [word for word in command("--cores", "1", SHARD) if word not in ("--quiet", "all")]
    second = run(loud, folder)
    assert second.returncode != 0 and "lock" in second.stderr.lower(), second.stderr
    assert first.wait() == 0
    assert_equal(finished, folder, [SHARD])


def test_a_second_run_of_another_checkout_in_the_same_results_is_refused(
    finished: Path, tmp_path: Path
) -> None:
    folders = [copy_workflow(tmp_path / name) for name in ("one", "another")]
    (tmp_path / "results").mkdir()
    for folder in folders:
        (folder / "results").symlink_to(tmp_path / "results", target_is_directory=True)
    first = start_slowly(folders[0])
    second = snakemake(folders[1], "--cores", "1", SHARD)
    assert second.returncode == 2, second.stderr
    assert f"process {first.pid}" in second.stderr
    assert first.wait() == 0
    assert not list((tmp_path / "results" / "test").glob(".*"))
    assert_equal(finished, folders[1], [SHARD])


def test_a_killed_run_leaves_no_lock_on_the_results(finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "killed")
    first = start_slowly(folder)
    os.killpg(first.pid, signal.SIGKILL)
    first.wait()
    # Snakemake's own lock outlives it; without it, this is as in another checkout.
    shutil.rmtree(folder / ".snakemake")
    result = snakemake(folder, "--cores", "1", SHARD)
    assert result.returncode == 0, result.stderr
    assert_equal(finished, folder, [SHARD])
