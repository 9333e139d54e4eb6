"""Fixtures of the navigation study's tests."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.navigation.tables.navigation_scores import navigation_scores
from tests.studies.navigation.examples import SPACES, make_curves, with_spaces


@pytest.fixture(scope="package")
def five_spaces(default_config) -> Config:
    return with_spaces(default_config, SPACES)


@pytest.fixture(scope="package")
def curves(five_spaces) -> pd.DataFrame:
    """Noisy runs that overlap; some never reach the threshold."""
    rng = np.random.default_rng(3)
    delay = {"truncated": 1.5, "adapted": 2.0, "full": 2.5, "random-half": 3.0, "inverse": 4.5}
    start = {(space, i): delay[space] + rng.normal(0, 1.3) for space in SPACES for i in range(6)}

    def value(space: str, i: int, k: int) -> float:
        return 40 / (1 + np.exp(-2 * (k - start[space, i]))) + rng.normal(0, 2)

    frame = make_curves(five_spaces, value)
    return frame.assign(success_rate=(frame["episode_return"] / 50).clip(0, 1))


@pytest.fixture(scope="package")
def scores(curves, five_spaces) -> pd.DataFrame:
    return navigation_scores(curves, five_spaces)
