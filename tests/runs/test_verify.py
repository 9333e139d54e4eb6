"""runs/checksums.py and runs/verify.py: what a run's checksums hold, and that no damaged file goes unnoticed."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from sensory_commutativity.test_runs import scp

from sensory_commutativity.cli import main
from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.checksums import (
    MANIFEST,
    files_of,
    read_manifest,
    sha256,
    write_manifest,
)
from sensory_commutativity.runs.verify import verify_run
from sensory_commutativity.storage.arrays import write_arrays
from sensory_commutativity.storage.checkpoints import save_state
from sensory_commutativity.storage.provenance import provenance
from sensory_commutativity.storage.tables import write_table
from sensory_commutativity.studies.plotting import Film, save

FILES = (
    "data/flatland_experiments/furnished.1-of-2.parquet",
    "data/mask_pairs/training.1-of-1.h5",
    "data/apartment_ready/a.json",
    "models/masks/raft.predictor",
    "models/navigation/full.1.policy",
    "tables/flatland_scp.parquet",
    "figures/a.gif",
    "figures/a.pdf",
    "figures/a.png",
)


@pytest.fixture(scope="module")
def made(tmp_path_factory, default_config) -> Path:
    """A small run with a file of every kind, and its checksums."""
    run = tmp_path_factory.mktemp("made") / "run"
    for folder in {Path(name).parent for name in FILES}:
        (run / folder).mkdir(parents=True, exist_ok=True)
    about = provenance(default_config)
    write_table(
        "flatland_scp", scp([0.5, 0.25]), run / FILES[0], default_config
    )  # a part has another name than its table
    write_arrays(run / FILES[1], "pairs", {"a": np.arange(300.0)}, about)
    (run / FILES[2]).write_text('{"seconds": 1.5}\n')
    save_state(run / FILES[3], {"about": about, "weights": {}})
    save_state(run / FILES[4], {"about": about})
    write_table("flatland_scp", scp([0.5]), run / FILES[5], default_config)
    figure, axes = plt.subplots(figsize=(1, 1))
    axes.plot([0, 1])
    film = Film(5, default_config)
    with film.saving(figure, str(run / FILES[6]), dpi=40):
        film.grab_frame()
        axes.plot([1, 0])
        film.grab_frame()
    save(figure, run / FILES[8], default_config)
    for name in (
        "logs/a.log",
        "benchmarks/a.tsv",
        "tables/.a.parquet",
        "data/.batches/a.parquet",
        "tables/notes.txt",
        "report.html",
    ):
        (run / name).parent.mkdir(parents=True, exist_ok=True)
        (run / name).write_text("no result")
    for name in FILES:
        os.utime(run / name, (1e9, 1e9))
    write_manifest(run / MANIFEST)
    return run


@pytest.fixture
def run(made, tmp_path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "run"))


def spoil(path: Path, data: bytes) -> None:
    """Other bytes, and the old time of writing: nobody wrote them."""
    when = path.stat()
    path.write_bytes(data)
    os.utime(path, ns=(when.st_atime_ns, when.st_mtime_ns))


def cut(data: bytes, kept: str) -> bytes:
    return data[: {"none": 0, "half": len(data) // 2, "all but one byte": len(data) - 1}[kept]]


def bad(run: Path) -> list[tuple[str, str]]:
    return [(one.path, one.verdict) for one in verify_run(run).bad]


def said(*arguments) -> tuple[int, str]:
    result = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.output


# ---- checksums -------------------------------------------------------------------------------------------------------------


def test_checksums_are_of_what_the_run_made_and_nothing_else(run):
    manifest = read_manifest(run / MANIFEST)
    assert list(manifest.hashes) == sorted(FILES) and manifest.wrong == ()
    assert all(sha256(run / name) == found for name, found in manifest.hashes.items())


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="no sha256sum here")
def test_sha256sum_agrees(run):
    def check() -> int:
        return subprocess.run(
            ["sha256sum", "--check", "--strict", "--quiet", MANIFEST], cwd=run, capture_output=True
        ).returncode

    assert check() == 0
    spoil(run / FILES[0], b"x")
    assert check() == 1


def test_what_was_not_written_since_keeps_its_checksum(run):
    before = (run / MANIFEST).read_text()
    spoil(run / "tables/flatland_scp.parquet", b"damaged")
    assert write_manifest(run / MANIFEST) == (0, len(FILES))
    assert (run / MANIFEST).read_text() == before
    assert bad(run) == [("tables/flatland_scp.parquet", "damaged")]


def test_what_was_written_since_or_is_new_or_gone_gets_its_own_line(run):
    (run / "models/navigation/full.1.policy").write_bytes(b"trained anew")
    later = (run / MANIFEST).stat().st_mtime_ns + 10**9
    os.utime(run / "models/navigation/full.1.policy", ns=(later, later))
    (run / "figures/new.pdf").write_bytes(b"new")
    (run / "figures/a.gif").unlink()
    assert write_manifest(run / MANIFEST) == (2, len(FILES) - 2)
    hashes = read_manifest(run / MANIFEST).hashes
    assert list(hashes) == files_of(run) and "figures/a.gif" not in hashes
    assert all(sha256(run / name) == found for name, found in hashes.items())


def test_a_folder_without_results_gets_no_checksums(tmp_path):
    with pytest.raises(UserError, match="no run"):
        write_manifest(tmp_path / MANIFEST)
    assert not list(tmp_path.iterdir())


# ---- verify ----------------------------------------------------------------------------------------------------------------


def test_a_run_as_it_was_made_is_right(run):
    assert said("verify", run) == (
        0,
        f"0 bad files; {len(FILES)} as their checksums say, 0 without one can be read\n",
    )
    (run / MANIFEST).unlink()
    assert said("verify", run) == (
        0,
        f"0 bad files; 0 as their checksums say, {len(FILES)} without one can be read\n",
    )


@pytest.mark.parametrize("name", FILES)
def test_with_checksums_every_flipped_bit_is_found(run, name):
    whole = (run / name).read_bytes()
    for at in (0, 1, len(whole) // 3, len(whole) // 2, len(whole) - 3, len(whole) - 1):
        for bit in (0, 7):
            spoil(run / name, whole[:at] + bytes([whole[at] ^ (1 << bit)]) + whole[at + 1 :])
            assert bad(run) == [(name, "damaged")]
    spoil(run / name, whole)
    assert bad(run) == []


@pytest.mark.parametrize("kept", ["none", "half", "all but one byte"])
@pytest.mark.parametrize("name", FILES)
def test_with_checksums_every_cut_is_found(run, name, kept):
    spoil(run / name, cut((run / name).read_bytes(), kept))
    code, text = said("verify", run)
    assert (
        code == 1 and text.splitlines()[0] == f"{run / name}: damaged: not what the checksums say"
    )
    assert "--remove" in text


@pytest.mark.parametrize("kept", ["none", "half", "all but one byte"])
@pytest.mark.parametrize("name", [name for name in FILES if not name.endswith(".json")])
def test_without_checksums_every_cut_is_found(run, name, kept):
    (run / MANIFEST).unlink()
    spoil(run / name, cut((run / name).read_bytes(), kept))
    assert bad(run) == [(name, "damaged")]


def test_what_was_rewritten_after_the_checksums_is_told_from_damage(run, default_config):
    write_table("flatland_scp", scp([0.75]), run / "tables/flatland_scp.parquet", default_config)
    later = (run / MANIFEST).stat().st_mtime_ns + 10**9
    os.utime(run / "tables/flatland_scp.parquet", ns=(later, later))
    assert bad(run) == [("tables/flatland_scp.parquet", "changed")]
    assert "run the workflow to its end" in said("verify", run)[1]
    (run / "tables/flatland_scp.parquet").write_bytes(b"half")
    os.utime(run / "tables/flatland_scp.parquet", ns=(later, later))
    assert bad(run) == [("tables/flatland_scp.parquet", "damaged")]


def test_files_of_other_programs_are_left_alone(run):
    pd.DataFrame({"a": [1]}).to_parquet(run / "tables" / "mine.parquet")
    (run / "tables" / "mine.txt").write_text("x")
    assert said("verify", run) == (
        0,
        f"0 bad files; {len(FILES)} as their checksums say, 0 without one can be read, 1 of kinds that cannot be checked\n",
    )


def test_remove_deletes_the_bad_files_and_the_checksums_and_nothing_else(run):
    spoil(run / "models/masks/raft.predictor", b"x")
    spoil(run / "figures/a.png", b"x")
    (run / "data/mask_pairs/training.1-of-1.h5").unlink()
    before = {path for path in run.rglob("*") if path.is_file()}
    code, text = said("verify", run, "--remove")
    gone = {run / "models/masks/raft.predictor", run / "figures/a.png", run / MANIFEST}
    assert code == 1 and before - {path for path in run.rglob("*") if path.is_file()} == gone
    assert all(f"{path}: deleted" in text for path in gone) and "run the workflow again" in text
    assert bad(run) == []


def test_remove_deletes_nothing_from_a_run_that_is_right(run):
    assert said("verify", run, "--remove")[0] == 0
    assert (run / MANIFEST).is_file() and files_of(run) == sorted(FILES)


def test_a_published_run_needs_no_raw_data(run):
    shutil.rmtree(run / "data")
    shutil.rmtree(run / "models/navigation")
    code, text = said("verify", run)
    assert code == 0
    assert text.splitlines()[:2] == [
        f"{run / 'data'}: raw data not here (3 files)",
        f"{run / 'models/navigation'}: models not here (1 files)",
    ]
    spoil(run / "figures/a.pdf", b"x")
    assert "take the bad files anew" in said("verify", run)[1]
    result = CliRunner().invoke(main, ["verify", str(run), "--remove"])
    assert isinstance(result.exception, UserError) and "data: not here" in str(result.exception)
    assert (run / "figures/a.pdf").exists() and (run / MANIFEST).exists()


def test_damaged_checksums_are_named_and_reach_no_file_outside_the_run(run, tmp_path):
    outside = tmp_path / "outside.png"
    outside.write_bytes(b"mine")
    lines = (run / MANIFEST).read_text().splitlines()
    (run / MANIFEST).write_text(
        "\n".join(
            [*lines[:-1], f"{'0' * 64}  ../outside.png", f"{'0' * 64}  {outside}", lines[-1][:40]]
        )
        + "\n"
    )
    n = len(lines)
    assert [(one.path, one.why[:7].strip()) for one in verify_run(run).bad] == [
        (MANIFEST, f"line {k}") for k in (n, n + 1, n + 2)
    ]
    said("verify", run, "--remove")
    assert outside.exists() and files_of(run) == sorted(FILES) and not (run / MANIFEST).exists()


def test_a_folder_that_is_no_run_is_told(tmp_path):
    result = CliRunner().invoke(main, ["verify", str(tmp_path)])
    assert (
        isinstance(result.exception, UserError)
        and "no run" in str(result.exception)
        and "results/default" in str(result.exception)
    )
