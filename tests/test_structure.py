"""How the package is cut: who may import what, examples in docstrings, and where compiled code is kept."""

from __future__ import annotations

import ast
import doctest
import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

import sensory_commutativity
from sensory_commutativity import compiled

PACKAGE = Path(sensory_commutativity.__file__).parent
SOURCES = sorted(PACKAGE.rglob("*.py"))


def imported(source: Path) -> set[str]:
    """Names of the modules that a file imports, anywhere in it; relative ones with their dots."""
    found = set()
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add("." * node.level + (node.module or ""))
    return found


def name(source: Path) -> str:
    return str(source.relative_to(PACKAGE))


def test_there_is_something_to_check():
    assert len(SOURCES) > 30
    assert "pymunk" in imported(PACKAGE / "worlds" / "flatland" / "world.py")


@pytest.mark.parametrize("source", SOURCES, ids=name)
def test_only_worlds_import_a_physics_engine(source):
    engines = {
        module for module in imported(source) if module.split(".")[0] in ("pymunk", "pybullet")
    }
    assert not engines or "worlds" in source.relative_to(PACKAGE).parts


@pytest.mark.parametrize("source", SOURCES, ids=name)
def test_nothing_knows_snakemake(source):
    assert not {module for module in imported(source) if module.split(".")[0] == "snakemake"}


@pytest.mark.parametrize(
    "source",
    [
        PACKAGE / f"{module}.py"
        for module in ("experiment", "residues", "sequences", "distances", "estimate")
    ],
    ids=name,
)
def test_the_idea_knows_no_world(source):
    assert not {module for module in imported(source) if "worlds" in module} - {".worlds.base"}


@pytest.mark.parametrize(
    "source", [s for s in SOURCES if "worlds" in s.relative_to(PACKAGE).parts], ids=name
)
def test_worlds_know_no_experiment(source):
    assert not {
        module
        for module in imported(source)
        if module.lstrip(".").split(".")[0] in ("experiment", "residues", "estimate", "stages")
    }


@pytest.mark.parametrize("source", SOURCES, ids=name)
def test_every_file_says_what_it_is_and_is_not_too_long(source):
    text = source.read_text()
    if text.strip():
        assert ast.get_docstring(ast.parse(text))
    assert len(text.splitlines()) <= 350  # design.md, section 4


@pytest.mark.parametrize(
    "module", ["worlds.corridor", "worlds.flatland.world", "worlds.base", "experiment", "sequences"]
)
def test_examples_in_docstrings(module):
    result = doctest.testmod(importlib.import_module(f"sensory_commutativity.{module}"))
    assert result.failed == 0
    if module in ("worlds.corridor", "worlds.flatland.world"):
        assert result.attempted > 3


# ---- compiled code ---------------------------------------------------------------------------------------------------------


def test_the_cache_is_named_after_the_sources(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = compiled._cache_folder()
    assert folder.is_relative_to(tmp_path)
    assert folder == compiled._cache_folder()
    read = Path.read_bytes
    edited = (
        PACKAGE / "worlds" / "flatland" / "room.py"
    )  # its functions are compiled into those of control.py
    monkeypatch.setattr(
        Path, "read_bytes", lambda self: read(self) + (b"# edited" if self == edited else b"")
    )
    assert compiled._cache_folder() != folder


def test_the_cache_goes_where_it_can_be_written(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert not compiled._cache_folder().is_relative_to(tmp_path)


def test_a_cache_that_was_asked_for_is_used(tmp_path):
    code = "import sensory_commutativity.compiled, numba; print(numba.config.CACHE_DIR)"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True
    )
    assert run.stdout.strip() == str(tmp_path)
