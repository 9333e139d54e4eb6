"""The folder in which numba caches compiled code."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from sensory_commutativity import compiled


def test_cache_folder_changes_with_the_source_of_any_world(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = compiled._cache_folder()
    assert folder.is_relative_to(tmp_path)
    assert folder == compiled._cache_folder()
    worlds = Path(compiled.__file__).parent / "worlds"
    edited = worlds / "flatland" / "room.py"  # its functions are compiled into other modules
    read = Path.read_bytes

    def read_edited(path: Path) -> bytes:
        return read(path) + (b"# edited" if path == edited else b"")

    assert edited.is_file()
    monkeypatch.setattr(Path, "read_bytes", read_edited)
    assert compiled._cache_folder() != folder


def test_numba_cache_dir_has_precedence(tmp_path):
    code = "import sensory_commutativity.compiled, numba; print(numba.config.CACHE_DIR)"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", code]
    run = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    assert run.stdout.strip() == str(tmp_path)
