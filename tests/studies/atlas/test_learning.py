"""The comparison of action spaces with the planar arm, at a tiny size."""

from __future__ import annotations

import gymnasium as gym
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from gymnasium.utils.env_checker import check_env

from sensory_commutativity import from_gymnasium, measure
from sensory_commutativity.studies.atlas.figures.learning_curves import learning_curves as figure
from sensory_commutativity.studies.atlas.tables.learning_comparisons import (
    MEASURES,
    learning_comparisons,
)
from sensory_commutativity.studies.atlas.tables.learning_curves import learning_curves
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import merge, read_settings, validate
from sensory_commutativity.worlds.planar_arm import ENVIRONMENT_ID, MAST, PlanarArmEnv
from tests.helpers import DEFAULT


@pytest.fixture(scope="module")
def config() -> Config:
    learning = {"seeds": 2, "steps": 4096, "evaluations": 2, "evaluation_episodes": 2,
                "action_spaces": ["full", "truncated"]}  # fmt: skip
    section = {"environments": {"reacher": {"env_id": "Reacher-v5"}}, "learning": learning}
    return validate(merge(read_settings(DEFAULT), {"atlas": section}))


def test_the_mast_touches_nothing_and_the_arm_pushes() -> None:
    check_env(PlanarArmEnv(), skip_render_check=True)
    world = from_gymnasium(gym.make(ENVIRONMENT_ID), control="direct", prefix=20, hold=1, tries=5)
    scp = measure(world, n=40, length=20, thresholds=0.01).scp()
    assert {scp[dof] for dof in MAST} == {1.0}
    assert scp["shoulder"] < 1 and scp["elbow"] < 1


def test_curves_repeat_and_are_compared(config: Config) -> None:
    scp = pd.DataFrame(
        {"dof": ["shoulder", "elbow", "wrist", *MAST], "scp": [0.8, 0.85, 0.9, 1.0, 1.0, 1.0]}
    )
    curves = pd.concat(
        [learning_curves(scp, config, space).compute(0, 2) for space in ("full", "truncated")],
        ignore_index=True,
    )
    again = learning_curves(scp, config, "truncated").compute(1, 2).reset_index(drop=True)
    first = curves[(curves["action_space"] == "truncated") & (curves["seed"] == 1)]
    pd.testing.assert_frame_equal(first.reset_index(drop=True), again)
    table = learning_comparisons(curves, config)
    assert list(table["measure"]) == list(MEASURES) and set(table["against"]) == {"full"}
    assert np.isfinite(table["p_adjusted"]).all()
    plt.close(figure({"learning_curves": curves}, config))
