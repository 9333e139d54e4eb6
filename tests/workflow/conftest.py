"""The finished workflow that the tests look at."""

from __future__ import annotations

from pathlib import Path

import pytest

from .running import copy_workflow, snakemake

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """All tests that look at a run go to one process, which makes it once; they take longest, and begin."""
    items.sort(key=lambda item: HERE not in item.path.parents)
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.xdist_group("workflow"))


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole workflow on the test profile, run to the end on two cores."""
    folder = copy_workflow(tmp_path_factory.mktemp("finished"))
    run = snakemake(folder, "--cores", "2")
    assert run.returncode == 0, run.stderr
    return folder
