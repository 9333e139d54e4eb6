"""Nothing outside of a run is read, packed or deleted; wrong clocks and odd names do no harm."""

from __future__ import annotations

import os
import shutil
import time
import zipfile
from pathlib import Path

import pytest
from click.testing import CliRunner

from sensory_commutativity.cli import main
from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.checksums import MANIFEST, read_manifest, write_manifest
from sensory_commutativity.runs.crate import write_crate
from sensory_commutativity.runs.entries import list_files
from sensory_commutativity.runs.verify import remove_bad_files, verify_run
from sensory_commutativity.storage.atomic import atomic_write
from tests.runs.examples import (
    FILES,
    PDF,
    PNG,
    TABLE,
    damage,
    set_time_after_checksums,
    write_run,
    write_scp,
)


@pytest.fixture(scope="module")
def written(tmp_path_factory, default_config) -> Path:
    run = tmp_path_factory.mktemp("written") / "run"
    write_run(run, default_config)
    return run


@pytest.fixture
def run(written, tmp_path) -> Path:
    return Path(shutil.copytree(written, tmp_path / "run"))


def snapshot(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("linked", ["data", "tables", "figures/a.png", MANIFEST, "config.yaml"])
def test_links_are_named_and_nothing_behind_them_is_touched(run, tmp_path, linked):
    outside = tmp_path / "outside"
    outside.mkdir()
    (run / linked).rename(outside / "moved")
    (outside / "secret.json").write_text('{"a": "secret"}')
    (run / linked).symlink_to(outside / "moved")
    before = snapshot(outside)
    result = verify_run(run)
    if linked != "config.yaml":
        assert (linked, "irregular") in [(bad.path, bad.status) for bad in result.bad]
        with pytest.raises(UserError, match="is a link"):
            remove_bad_files(run, result)
    CliRunner().invoke(main, ["run", "verify", str(run), "--remove"])
    CliRunner().invoke(main, ["run", "verify", str(run), "--no-redraw"])
    with pytest.raises(UserError) as caught:
        write_crate(run, tmp_path / "crate.zip", with_data=True)
    assert "link" in str(caught.value) or "not a run" in str(caught.value)
    assert snapshot(outside) == before and not (tmp_path / "crate.zip").exists()


def test_links_within_files_that_are_deleted_are_not_followed(run, tmp_path):
    (tmp_path / "mine.png").write_bytes(b"mine")
    damage(run / PDF, b"x")
    result = verify_run(run)
    (run / PDF).unlink()
    (run / PDF).symlink_to(tmp_path / "mine.png")  # between the check and the deletion
    remove_bad_files(run, result)
    assert (tmp_path / "mine.png").read_bytes() == b"mine"


def test_pipes_and_sockets_among_the_results_do_not_block(run):
    os.mkfifo(run / "tables" / "pipe.parquet")
    (bad,) = verify_run(run).bad
    assert (bad.path, bad.status) == ("tables/pipe.parquet", "irregular")
    with pytest.raises(UserError, match="a pipe"):
        write_manifest(run / MANIFEST)


@pytest.mark.parametrize(
    "line", ["config.yaml", "report.html", "tables/../../outside.json", "/etc/passwd", "tables",
             "logs/a.log", "tables/.hidden.parquet", "tables/notes.txt"],
)  # fmt: skip
def test_checksums_of_what_is_no_result_are_invalid_and_delete_nothing(run, line):
    (run.parent / "outside.json").write_text("{}")
    with (run / MANIFEST).open("a") as file:
        file.write(f"{'0' * 64}  {line}\n")
    before = set(snapshot(run.parent))
    result = verify_run(run)
    assert [bad.path for bad in result.bad] == [MANIFEST]
    removed = remove_bad_files(run, result)
    assert removed == [MANIFEST] and before - set(snapshot(run.parent)) == {run / MANIFEST}


def test_a_file_made_again_is_not_damaged_because_the_checksums_are_from_the_future(
    run, default_config
):
    future = time.time_ns() + 10**9 * 3600 * 24 * 365
    os.utime(run / MANIFEST, ns=(future, future))
    assert verify_run(run).bad == ()
    write_scp(run / TABLE, [0.75], default_config)
    (bad,) = verify_run(run).bad
    assert (bad.path, bad.status) == (TABLE, "changed")
    write_manifest(run / MANIFEST)
    assert verify_run(run).bad == ()
    damage(run / PNG, (run / PNG).read_bytes()[:-20])
    set_time_after_checksums(run, PNG)
    assert [bad.status for bad in verify_run(run).bad] == ["damaged"]
    write_manifest(run / MANIFEST)
    assert [bad.status for bad in verify_run(run).bad] == ["damaged"], "damage got a checksum"


def test_names_with_newlines_and_backslashes_are_recorded_as_sha256sum_does(run):
    names = ["figures/a\nb.png", "figures/a\\nb.png", "figures/\\.png", "figures/ü \u202e.png"]
    for name in names:
        shutil.copy(run / PNG, run / name)
    write_manifest(run / MANIFEST)
    manifest = read_manifest(run / MANIFEST)
    assert manifest.invalid_lines == () and set(manifest.hashes) == {*FILES, *names}
    assert set(list_files(run)) == set(manifest.hashes)
    assert verify_run(run).bad == ()
    output = CliRunner().invoke(main, ["run", "verify", str(run), "--files-only"]).output
    assert all(line.isprintable() for line in output.splitlines())


def test_a_crate_of_a_run_without_links_is_written(run, tmp_path):
    write_crate(run, tmp_path / "crate.zip", with_data=True)
    assert any(name.endswith(TABLE) for name in zipfile.ZipFile(tmp_path / "crate.zip").namelist())


def test_files_are_written_only_where_a_file_or_nothing_is(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "null").symlink_to("/dev/null")
    (tmp_path / "folder").mkdir()
    for path in (tmp_path / "pipe", tmp_path / "null", tmp_path / "folder", Path("/dev/full")):
        with pytest.raises(UserError, match="which writing would replace"), atomic_write(path):
            pytest.fail("written")
    assert not Path("/dev/full").is_file() and (tmp_path / "pipe").is_fifo()
    (tmp_path / "file").write_text("a")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    for name in ("file", "link", "new"):
        with atomic_write(tmp_path / name) as temporary:
            temporary.write_text("b")
        assert (tmp_path / name).read_text() == "b"
