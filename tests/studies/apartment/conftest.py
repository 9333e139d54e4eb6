"""Fixtures of the apartment's tests."""

from __future__ import annotations

import pandas as pd
import pytest

from sensory_commutativity.studies.apartment.tables.apartment_order import apartment_order
from sensory_commutativity.studies.config import Config
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from tests.studies.apartment.examples import FETCH, N, make_experiments, with_experiments


@pytest.fixture(scope="package")
def config(default_config) -> Config:
    return with_experiments(default_config, N)


@pytest.fixture(scope="package")
def scp(config) -> dict[str, dict[str, float]]:
    """SCPs of both robots; those of JackRabbot rise along its hierarchy."""
    jackrabbot = load_robot(config.apartment.robots["jackrabbot"].description)
    rising = {
        dof: 0.2 + 0.2 * i for i, dofs in enumerate(jackrabbot.hierarchy.values()) for dof in dofs
    }
    return {"fetch": FETCH, "jackrabbot": rising}


@pytest.fixture(scope="package")
def experiments(config, scp) -> pd.DataFrame:
    return make_experiments(config, scp)


@pytest.fixture(scope="package")
def order(experiments, config) -> pd.DataFrame:
    """The table apartment_order; it takes seconds."""
    return apartment_order(experiments, config)
