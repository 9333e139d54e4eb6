"""A configuration of few experiments."""

from __future__ import annotations

import pytest

from sensory_commutativity.studies.config import Config
from tests.helpers import update_flatland


@pytest.fixture(scope="session")
def few_config(small_config_of_tests) -> Config:
    """The configuration of the tests, with shards of few rows."""
    return update_flatland(small_config_of_tests, experiments_per_job=3)


@pytest.fixture(scope="session")
def small_config_of_tests() -> Config:
    """config/config.yaml with config/test.yaml over it."""
    from sensory_commutativity.studies.loading import load
    from tests.helpers import DEFAULT, ROOT

    return load(DEFAULT, ROOT / "config" / "test.yaml")
