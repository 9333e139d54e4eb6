"""Fixtures for all tests."""

from __future__ import annotations

import os

os.environ.setdefault(
    "OMP_NUM_THREADS", "1"
)  # as every job of the workflow; read when torch is imported

import pytest
import yaml
from hypothesis import settings
from sensory_commutativity.helpers import DEFAULT, changed

from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load, validate

settings.register_profile("repeatable", max_examples=50, deadline=None, derandomize=True)
settings.load_profile("repeatable")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log):
    """Tests that look at the finished workflow go to one process, which makes it once; all others to whichever is free."""
    from xdist.scheduler import LoadScopeScheduling

    class Scheduling(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return "workflow" if nodeid.startswith("tests/workflow/") else nodeid

    return Scheduling(config, log)


@pytest.fixture(scope="session")
def default_config() -> Config:
    return load(DEFAULT)


@pytest.fixture
def default_settings() -> dict:
    """What config/default.yaml holds, to be spoilt."""
    return yaml.safe_load(DEFAULT.read_text())


@pytest.fixture(scope="session")
def tiny_config(default_config: Config) -> Config:
    """So small that a stage takes no time."""
    some = {"experiments": 3}
    return changed(
        default_config,
        sequence_length=4,
        reference={"experiments": 5},
        free_space=some,
        combinations=some,
        variants=some,
        sensitivity={"lengths": [2, 6], **some},
        commutation={"settled_rest_steps": 5, **some},
        baselines={"transitions": 100, "training": 52, "epochs": 1, "batch_size": 16},
        experiments_per_job=3,
    )


@pytest.fixture(scope="session")
def tiny_config_file(tiny_config: Config, tmp_path_factory) -> str:
    file = tmp_path_factory.mktemp("config") / "tiny.yaml"
    file.write_text(yaml.safe_dump(tiny_config.model_dump(mode="json")))
    assert validate(yaml.safe_load(file.read_text())) == tiny_config
    return str(file)
