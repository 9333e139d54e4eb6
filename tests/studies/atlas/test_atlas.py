"""The atlas at a tiny size: rows, shards, verdicts, figure."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.studies.atlas.builders import approach_fetch, atlas, build_environment
from sensory_commutativity.studies.atlas.figures.atlas_scp import atlas_scp as figure
from sensory_commutativity.studies.atlas.tables.atlas_detection import atlas_detection
from sensory_commutativity.studies.atlas.tables.atlas_experiments import atlas_experiments
from sensory_commutativity.studies.atlas.tables.atlas_scp import atlas_scp
from sensory_commutativity.studies.atlas.tables.snapshot_exactness import snapshot_exactness
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.loading import load, merge, read_settings, validate
from tests.helpers import DEFAULT, ROOT

ENVIRONMENTS = {
    "reacher": {"env_id": "Reacher-v5", "length": 10, "rest_steps": 50},
    "reacher-torque": {"env_id": "Reacher-v5", "control": "direct", "length": 10, "rest_steps": 0},
}


@pytest.fixture(scope="module")
def config() -> Config:
    section = {"starts": 6, "exactness_tries": 2, "environments": ENVIRONMENTS}
    return validate(merge(read_settings(DEFAULT), {"atlas": section}))


@pytest.fixture(scope="module")
def experiments(config: Config) -> pd.DataFrame:
    frames = [atlas_experiments(config, run).compute(0, 6) for run in ENVIRONMENTS]
    return pd.concat(frames, ignore_index=True)


def test_rows_do_not_depend_on_how_starts_are_cut(config, experiments) -> None:
    compute = atlas_experiments(config, "reacher").compute
    parts = pd.concat([compute(4, 6), compute(0, 4)]).sort_values("experiment", kind="stable")
    whole = experiments[experiments["environment"] == "reacher"]
    assert parts.reset_index(drop=True).equals(whole.reset_index(drop=True))


def test_every_declared_column_is_computed(config, experiments) -> None:
    table = atlas_scp(experiments, config)
    assert set(atlas_scp.column_names) <= set(table.columns)
    assert len(table) == 2 * 2 * len(atlas(config).thresholds)
    at = table[table["threshold"] == 0.1].set_index("environment")
    assert at.loc["reacher", "scp"].min() == 1 and set(at.loc["reacher", "control"]) == {"servo"}
    torque = at.loc["reacher-torque"]
    assert torque["scp"].max() < 1 and torque["verdict"].str.startswith("no effect").all()
    drawn = figure({"atlas_scp": table}, config)
    titles = [axes.get_title() for axes in drawn.axes if axes.get_visible()]
    assert titles == ["reacher (servo)", "reacher-torque (direct)"]
    plt.close(drawn)


def test_detection_needs_events(config, experiments) -> None:
    assert len(atlas_detection(experiments, config)) == 0
    with_events = experiments.assign(
        moved=(experiments["distance"] > experiments["distance"].median()).astype(float)
    )
    found = atlas_detection(with_events, config)
    assert (found["auc"] == 1).all() and (found["ci_low"] <= found["auc"]).all()


def test_every_way_is_tried(config) -> None:
    rows = snapshot_exactness(config, "reacher").set_index("way")
    assert rows.loc[["native", "replay", "fork"], "exact"].tolist() == [2, 2, 2]
    assert rows.loc["deepcopy", "exact"] == 0 and (rows["keep_ms"] > 0).all()


def test_an_approach_ends_beside_the_object() -> None:
    settings = load(DEFAULT, ROOT / "config" / "atlas.yaml").atlas
    assert settings is not None
    world = build_environment(settings.environments["fetch-push-near"])
    world.reset(np.random.default_rng(0))
    observation = world.observe()
    between = np.linalg.norm(observation[6:8] - observation[9:11])
    assert 0.03 < between < 0.12
    action = approach_fetch(observation, np.random.default_rng(0))
    assert action.shape == (4,) and action[3] == 0


def test_without_a_section_there_is_no_atlas() -> None:
    with pytest.raises(ConfigError, match=r"merge config/atlas.yaml over it"):
        atlas(load(DEFAULT))
