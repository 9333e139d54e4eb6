"""The finished workflow that the tests look at."""

from __future__ import annotations

from pathlib import Path

import pytest

from .running import copy_workflow, snakemake


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole workflow on the test profile, run to the end on two cores."""
    folder = copy_workflow(tmp_path_factory.mktemp("finished"))
    run = snakemake(folder, "--cores", "2")
    assert run.returncode == 0, run.stderr
    return folder
