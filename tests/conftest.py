"""Fixtures for all tests."""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # as in the workflow; read when torch is imported

import pytest
from hypothesis import settings

from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load, read_settings, write_resolved
from tests.helpers import DEFAULT, update_flatland

settings.register_profile("repeatable", max_examples=50, deadline=None, derandomize=True)
settings.load_profile("repeatable")


SLURM = "tests/workflow/test_slurm.py"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Start with the tests of the workflow, which take longest."""
    items.sort(key=lambda item: (not item.nodeid.startswith("tests/workflow/"),
                                 item.nodeid.startswith(SLURM)))  # fmt: skip


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log):
    """Send the tests of the workflow to one process, those of Slurm, which mostly wait, to another,
    and each other file to whichever is free."""
    from xdist.scheduler import LoadScopeScheduling

    class Scheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.split("::")[0]
            workflow = file.startswith("tests/workflow/") and file != SLURM
            return "workflow" if workflow else file

    return Scheduling(config, log)


@pytest.fixture(scope="session")
def default_config() -> Config:
    return load(DEFAULT)


@pytest.fixture
def default_settings() -> dict:
    """The contents of config/config.yaml, which a test may change."""
    return read_settings(DEFAULT)


@pytest.fixture(scope="session")
def tiny_config(default_config: Config) -> Config:
    """A configuration so small that a table takes no time."""
    few = {"experiments": 3}
    return update_flatland(
        default_config,
        sequence_length=4,
        reference={"experiments": 5},
        free_space=few,
        combinations=few,
        variants=few,
        sensitivity={"lengths": [2, 6], **few},
        commutation={"settled_rest_steps": 5, **few},
        baselines={"transitions": 100, "training": 52, "epochs": 1, "batch_size": 16},
        experiments_per_job=3,
    )


@pytest.fixture(scope="session")
def tiny_config_file(tiny_config: Config, tmp_path_factory) -> str:
    file = tmp_path_factory.mktemp("config") / "tiny.yaml"
    write_resolved(tiny_config, file)
    assert load(file) == tiny_config
    return str(file)
