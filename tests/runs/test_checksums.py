"""Checksums of the files of a run."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from sensory_commutativity.errors import UserError
from sensory_commutativity.runs.checksums import (
    MANIFEST,
    list_files,
    read_manifest,
    write_manifest,
)
from sensory_commutativity.storage.checkpoints import save_state
from sensory_commutativity.storage.hashing import sha256
from tests.runs.examples import FILES, GIF, POLICY, SHARD, TABLE, damage, set_time_after_checksums


def test_all_results_and_nothing_else_have_checksums(example_run):
    manifest = read_manifest(example_run / MANIFEST)
    assert list(manifest.hashes) == list_files(example_run) == sorted(FILES)
    assert manifest.invalid_lines == ()
    assert all(sha256(example_run / name) == value for name, value in manifest.hashes.items())


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="sha256sum is not installed")
def test_sha256sum_agrees(run):
    command = ["sha256sum", "--check", "--strict", "--quiet", MANIFEST]
    assert subprocess.run(command, cwd=run, capture_output=True).returncode == 0
    damage(run / SHARD, b"x")
    assert subprocess.run(command, cwd=run, capture_output=True).returncode == 1


def test_an_unmodified_file_keeps_its_checksum(run):
    before = (run / MANIFEST).read_text()
    damage(run / TABLE, b"damaged")
    assert write_manifest(run / MANIFEST) == (0, len(FILES))
    assert (run / MANIFEST).read_text() == before


def test_modified_new_and_deleted_files_are_updated(run):
    save_state(run / POLICY, {"about": {}, "trained": "again"})
    set_time_after_checksums(run, POLICY)
    (run / "figures/new.pdf").write_bytes(b"new")
    (run / GIF).unlink()
    assert write_manifest(run / MANIFEST) == (2, len(FILES) - 2)
    hashes = read_manifest(run / MANIFEST).hashes
    assert list(hashes) == list_files(run)
    assert GIF not in hashes and "figures/new.pdf" in hashes
    assert all(sha256(run / name) == value for name, value in hashes.items())


def test_a_folder_without_results_gets_no_checksums(tmp_path):
    with pytest.raises(UserError, match="not a run"):
        write_manifest(tmp_path / MANIFEST)
    assert not list(tmp_path.iterdir())
