"""Folders: checks that they are writable, a lock, the cache."""

from __future__ import annotations

import atexit
import fcntl
import os
import tempfile
from pathlib import Path

import pytest

from sensory_commutativity.errors import UserError
from sensory_commutativity.storage.folders import cache_folder, check_writable, lock_folder


def refuse(*folders: Path):
    """A TemporaryFile that may not be created in `folders`: permissions do not bind root."""
    create = tempfile.TemporaryFile

    def temporary_file(dir):
        if Path(dir) in folders:
            raise PermissionError(13, "Permission denied", str(dir))
        return create(dir=dir)

    return temporary_file


def test_a_folder_that_can_be_created_is_writable(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for folder in (tmp_path, tmp_path / "new", tmp_path / "new/deep/er", Path("relative/folder")):
        check_writable(folder)
        assert not list(tmp_path.iterdir()), folder  # nothing is created


def test_a_file_in_the_path_is_reported(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "file"
    file.write_text("x")
    for folder in (file, file / "results", file / "deep/er"):
        with pytest.raises(UserError, match=f"{file}: is a file.*; use another") as error:
            check_writable(folder, "use another")
        assert str(folder) in str(error.value)
    with pytest.raises(UserError, match="file: is a file"):
        check_writable(Path("file/results"))
    assert file.read_text() == "x"


def test_missing_permissions_are_reported(tmp_path, monkeypatch):
    tables, figures = tmp_path / "tables", tmp_path / "figures"
    tables.mkdir()
    figures.mkdir()
    monkeypatch.setattr(tempfile, "TemporaryFile", refuse(tables))
    with pytest.raises(UserError, match="tables: cannot be written to"):
        check_writable(tmp_path)  # a subfolder that another user made, say
    check_writable(figures)
    monkeypatch.setattr(tempfile, "TemporaryFile", refuse(tmp_path))
    with pytest.raises(
        UserError, match=r"cannot be written to \(Permission denied\).*; use another"
    ) as error:
        check_writable(tmp_path / "results", "use another")
    assert str(tmp_path) in str(error.value) and "\n" not in str(error.value)


def test_a_locked_folder_cannot_be_locked_until_it_is_released(tmp_path, monkeypatch):
    at_exit = []
    monkeypatch.setattr(atexit, "register", at_exit.append)
    folder = tmp_path / "results"
    lock_folder(folder)
    with pytest.raises(UserError, match=f"locked by process {os.getpid()} on .*; wait") as error:
        lock_folder(folder, "wait")
    assert str(folder) in str(error.value)
    lock_folder(tmp_path / "other")
    at_exit[0]()
    assert not list(folder.iterdir())
    lock_folder(folder)
    at_exit[-1]()


def test_a_file_system_without_locks_is_not_locked(tmp_path, monkeypatch):
    def flock(*_):
        raise OSError("not supported")

    monkeypatch.setattr(fcntl, "flock", flock)
    lock_folder(tmp_path)
    lock_folder(tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_cache_is_where_files_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder("a", "b") == tmp_path / "sensory-commutativity" / "a" / "b"
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert cache_folder().is_relative_to(tempfile.gettempdir())
    assert not cache_folder().is_relative_to(tmp_path)
