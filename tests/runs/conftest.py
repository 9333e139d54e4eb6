"""Fixtures for the tests of finished runs."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.runs.examples import write_run


@pytest.fixture(scope="session")
def example_run(tmp_path_factory, default_config) -> Path:
    """A small run with a file of every type and its checksums; not to be changed."""
    run = tmp_path_factory.mktemp("example") / "run"
    write_run(run, default_config)
    return run


@pytest.fixture
def run(example_run, tmp_path) -> Path:
    """A copy of the example run."""
    return Path(shutil.copytree(example_run, tmp_path / "run"))
