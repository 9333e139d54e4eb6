"""Faults, injected: each ends in complete results that equal the undisturbed run's. Those of a cluster are in test_slurm.py."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest
from sensory_commutativity.running import (
    ENVIRONMENT,
    begin,
    command,
    copy_workflow,
    digests,
    hashes,
    in_its_place,
    snakemake,
    wait_until,
)

RESULTS = Path("results", "test")
PART = RESULTS / "data" / "flatland_commutation" / "furnished.1-of-2.parquet"
OF_EACH_KIND = (
    PART,
    RESULTS / "data" / "mask_pairs" / "validation.1-of-1.h5",
    RESULTS / "models" / "masks" / "difference.predictor",
    RESULTS / "figures" / "flatland_world.png",
)
"""Files of each kind that take little work."""
DAMAGED = {
    RESULTS / "data" / "flatland_baselines" / "head.parquet": "flipped",
    RESULTS / "data" / "mask_tuples" / "as-trained.1-of-2.h5": "truncated",
    RESULTS / "models" / "masks" / "difference.predictor": "flipped",
    RESULTS / "tables" / "navigation_profiles.parquet": "truncated",
    RESULTS / "figures" / "flatland_world.png": "flipped",
}
"""Finished outputs, and what becomes of them."""
SLOWLY = 'touch begun; sleep 5; exec "$@"'


def expect_equal(finished: Path, folder: Path, files: Iterable[Path]) -> None:
    """Demand that `files` are those of the undisturbed run, and that nothing half written lies about."""
    expected = digests(finished, files)
    assert all(expected.values()) and digests(folder, files) == expected
    assert not list((folder / RESULTS).rglob(".*.part*"))


def test_workers_killed_while_they_write_files_of_each_kind(finished: Path, tmp_path: Path) -> None:
    folder, kinds = copy_workflow(tmp_path / "killed"), tmp_path / "kinds"
    kinds.mkdir()
    path = os.pathsep.join(
        filter(None, [str(Path(__file__).parent / "killing"), os.environ.get("PYTHONPATH")])
    )
    environment = {**ENVIRONMENT, "PYTHONPATH": path, "KILLED": str(kinds)}
    runs = 0
    while any(not (folder / file).exists() for file in OF_EACH_KIND):
        run = subprocess.run(
            command("--cores", "2", "--keep-going", *map(str, OF_EACH_KIND)),
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,
        )
        runs += 1
        assert runs <= 1 + len(OF_EACH_KIND), run.stderr
        whole = [file for file in OF_EACH_KIND if (folder / file).exists()]
        assert digests(folder, whole) == digests(finished, whole)
    assert runs > 1 and {kind.name for kind in kinds.iterdir()} >= {
        ".parquet",
        ".h5",
        ".predictor",
        ".png",
    }
    expect_equal(finished, folder, OF_EACH_KIND)


def damage(path: Path, how: str) -> None:
    """Cut a file in half, or turn one bit in its middle over."""
    data = bytearray(path.read_bytes())
    if how == "truncated":
        del data[len(data) // 2 :]
    else:
        data[len(data) // 2] ^= 1
    path.write_bytes(data)


def verify(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    program = Path(sys.executable).parent / "sensory-commutativity"
    return subprocess.run(
        [program, "verify", RESULTS, *options],
        cwd=folder,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=300,
    )


def test_finished_files_that_were_damaged_are_named_and_made_anew(
    finished: Path, tmp_path: Path
) -> None:
    folder = shutil.copytree(finished, tmp_path / "damaged")
    assert verify(folder).returncode == 0
    before = hashes(folder / RESULTS / "tables")
    for file, how in DAMAGED.items():
        damage(folder / file, how)
    found = verify(folder)
    assert found.returncode == 1
    assert {
        Path(line.split(":")[0])
        for line in found.stdout.splitlines()
        if ": damaged: " in line or ": changed: " in line
    } == set(DAMAGED)
    verify(folder, "--remove")
    run = snakemake(folder, "--cores", "2")
    assert run.returncode == 0, run.stderr
    expect_equal(finished, folder, DAMAGED)
    assert hashes(folder / RESULTS / "tables") == before
    assert verify(folder).returncode == 0


@pytest.mark.skipif(
    os.name != "posix" or os.geteuid() != 0, reason="a small disk is mounted, which needs root"
)
def test_a_full_disk(finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "full")
    disk = folder / "results"
    disk.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(disk)],
        capture_output=True,
        text=True,
    )
    if mounted.returncode:
        pytest.skip(f"no small disk can be mounted here: {mounted.stderr.strip()}")
    try:
        files = [OF_EACH_KIND[1], OF_EACH_KIND[3]]
        run = snakemake(folder, "--cores", "2", "--keep-going", *map(str, files))
        assert run.returncode == 1, run.stderr
        logs = "".join(log.read_text() for log in (folder / RESULTS / "logs").rglob("*.log"))
        assert "No space left on device; make room" in logs + run.stderr
        assert "Traceback" not in logs, logs
        assert not [file for file in files if (folder / file).exists()]
        subprocess.run(["mount", "-o", "remount,size=200m", str(disk)], check=True)
        run = snakemake(folder, "--cores", "2", *map(str, files))
        assert run.returncode == 0, run.stderr
        expect_equal(finished, folder, files)
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=False)


def test_a_second_run_in_the_same_checkout_is_refused(finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "twice")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", SLOWLY)
    first = begin(command("--cores", "1", str(PART)), folder, ENVIRONMENT)
    wait_until((folder / "begun").exists, first, "a job")
    arguments = [
        argument
        for argument in command("--cores", "1", str(PART))
        if argument not in ("--quiet", "all")
    ]
    second = subprocess.run(
        arguments, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=120
    )
    assert second.returncode != 0 and "lock" in second.stderr.lower(), second.stderr
    assert first.wait(timeout=120) == 0
    expect_equal(finished, folder, [PART])


def test_a_second_run_of_another_checkout_in_the_same_results_is_refused(
    finished: Path, tmp_path: Path
) -> None:
    folders = [copy_workflow(tmp_path / name) for name in ("one", "another")]
    for folder in folders:
        in_its_place(folder, "flatland.smk", "flatland-commutation-part", SLOWLY)
        (folder / "results").symlink_to(tmp_path / "results", target_is_directory=True)
    (tmp_path / "results").mkdir()
    arguments = command("--cores", "1", str(PART))
    first = begin(arguments, folders[0], ENVIRONMENT)
    wait_until((folders[0] / "begun").exists, first, "a job")
    second = snakemake(folders[1], "--cores", "1", str(PART))
    assert second.returncode == 2, second.stderr
    assert f"process {first.pid}" in second.stderr and not (folders[1] / "begun").exists()
    assert first.wait(timeout=120) == 0
    assert not (tmp_path / "results" / "test" / ".held").exists()
    expect_equal(finished, folders[1], [PART])


def test_a_run_that_was_killed_holds_nothing(finished: Path, tmp_path: Path) -> None:
    folder = copy_workflow(tmp_path / "killed")
    in_its_place(folder, "flatland.smk", "flatland-commutation-part", SLOWLY)
    first = begin(command("--cores", "1", str(PART)), folder, ENVIRONMENT)
    wait_until((folder / "begun").exists, first, "a job")
    os.killpg(first.pid, signal.SIGKILL)
    first.wait()
    shutil.rmtree(
        folder / ".snakemake"
    )  # with Snakemake's lock, which outlives it: as in another checkout
    run = snakemake(folder, "--cores", "1", str(PART))
    assert run.returncode == 0, run.stderr
    expect_equal(finished, folder, [PART])
