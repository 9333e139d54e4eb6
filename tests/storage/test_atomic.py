"""A file has its name only when it is complete."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys

import pytest

from sensory_commutativity.errors import UserError
from sensory_commutativity.storage.atomic import atomic_write


def test_a_file_gets_its_name_when_the_block_ends(tmp_path):
    path = tmp_path / "a" / "file.txt"
    for content in ("first", "second"):
        before = path.read_text() if path.exists() else None
        with atomic_write(path) as temporary:
            assert temporary.parent == path.parent  # renaming works within one file system only
            assert temporary.suffix == ".txt"
            temporary.write_text(content)
            assert (path.read_text() if path.exists() else None) == before
        assert path.read_text() == content
        assert os.listdir(path.parent) == ["file.txt"]


def test_a_block_that_fails_changes_nothing(tmp_path):
    path = tmp_path / "file.txt"
    for existing in ([], ["file.txt"]):
        for error in (ValueError, KeyboardInterrupt, SystemExit):
            with pytest.raises(error), atomic_write(path) as temporary:
                temporary.write_text("half")
                raise error
            assert os.listdir(tmp_path) == existing
        path.write_text("old")
    assert path.read_text() == "old"


def test_a_full_disk_is_explained(tmp_path):
    path = tmp_path / "file.txt"
    message = "cannot be written: .*; free some space and run again"
    with pytest.raises(UserError, match=message), atomic_write(path):
        raise OSError(errno.ENOSPC, "full")
    with pytest.raises(OSError, match="other"), atomic_write(path):
        raise OSError(errno.EIO, "other")


def test_temporary_files_of_a_killed_process_are_removed(tmp_path):
    code = (
        "import os, sys, pathlib; from sensory_commutativity.storage.atomic import atomic_write\n"
        "with atomic_write(pathlib.Path(sys.argv[1])) as temporary:\n"
        "    temporary.write_text('half'); os._exit(9)"
    )
    path, other = tmp_path / "file[1].txt", tmp_path / "other.txt"
    for killed in (path, other):
        assert subprocess.run([sys.executable, "-c", code, str(killed)]).returncode == 9
    assert len(os.listdir(tmp_path)) == 2 and not path.exists()
    with atomic_write(path) as temporary:
        temporary.write_text("complete")
    assert path.read_text() == "complete"
    assert len(os.listdir(tmp_path)) == 2  # that of the other file is left alone


def test_files_have_the_usual_permissions(tmp_path):
    before = os.umask(0o022)
    try:
        for umask, mode in ((0o022, 0o644), (0o077, 0o600), (0o002, 0o664)):
            os.umask(umask)
            with atomic_write(tmp_path / "file.txt") as temporary:
                temporary.write_text("x")
            assert stat.S_IMODE((tmp_path / "file.txt").stat().st_mode) == mode
            assert os.umask(umask) == umask  # reading the umask did not change it
    finally:
        os.umask(before)
