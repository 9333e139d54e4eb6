"""Fixtures of the studies' tests."""

from __future__ import annotations

import pytest

from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load
from tests.helpers import DEFAULT, ROOT


@pytest.fixture(scope="session")
def small_config() -> Config:
    """config/config.yaml with config/test.yaml over it."""
    return load(DEFAULT, ROOT / "config" / "test.yaml")
