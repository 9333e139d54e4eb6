"""folders.py: can results be written there?"""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.storage.folders import check_writable


@pytest.mark.parametrize("inside", [".", "new", "new/deep/er"])
def test_a_folder_that_can_be_made(inside, tmp_path):
    check_writable(tmp_path / inside)
    assert not list(tmp_path.iterdir())  # nothing was left behind, nor made


@pytest.mark.parametrize("inside", ["file", "file/results", "file/deep/er"])
def test_a_file_in_the_way(inside, tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(ConfigError, match=r"is a file.*'results'") as caught:
        check_writable(tmp_path / inside)
    assert str(tmp_path / "file") in str(caught.value)
    assert (tmp_path / "file").read_text() == "x"


def test_a_folder_that_may_not_be_written(tmp_path, monkeypatch):
    """Permissions mean nothing to root, so the refusal is acted."""

    def refuse(dir):
        raise PermissionError(13, "Permission denied", str(dir))

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    with pytest.raises(
        ConfigError, match=r"cannot be written to \(Permission denied\).*'results'"
    ) as caught:
        check_writable(tmp_path / "results")
    assert str(tmp_path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_folder_inside_that_may_not_be_written(tmp_path, monkeypatch):
    """Left by another user's run, say."""
    (tmp_path / "tables").mkdir()
    (tmp_path / "figures").mkdir()
    allowed = tempfile.TemporaryFile

    def refuse(dir):
        if Path(dir).name == "tables":
            raise PermissionError(13, "Permission denied", str(dir))
        return allowed(dir=dir)

    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    with pytest.raises(ConfigError, match="tables: cannot be written to"):
        check_writable(tmp_path)
    check_writable(tmp_path / "figures")


def test_a_relative_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    check_writable(Path("results/default"))
    Path("results").write_text("x")
    with pytest.raises(ConfigError, match="is a file"):
        check_writable(Path("results/default"))
